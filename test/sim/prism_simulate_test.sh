#!/usr/bin/env bash
# prism_simulate on bad input: exit 2 (or 1), one line naming the cause, nothing half written.
# Usage: prism_simulate_test.sh PRISM_SIMULATE CAMERA
set -uo pipefail
program=$1
camera=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0

# expect_error NAME TEXT COMMAND...: status 1 or 2, one line on stderr that holds TEXT.
expect_error() {
  local name=$1 text=$2
  shift 2
  "$@" >"$work/out" 2>"$work/err"
  local status=$?
  if [ $status -ne 1 ] && [ $status -ne 2 ]; then
    echo "FAIL $name: status $status"; failures=$((failures + 1))
  elif [ "$(grep -c . "$work/err")" -ne 1 ] || ! grep -qF -- "$text" "$work/err"; then
    echo "FAIL $name: expected one line with '$text', got:"; cat "$work/err"; failures=$((failures + 1))
  fi
  if find "$work" -name '.partial_*' | grep -q .; then
    echo "FAIL $name: a half-written file is left"; failures=$((failures + 1))
  fi
}

plane=("$program" --scene=plane "--camera=$camera" --frames=2 --truth_every=1)

cat >"$work/lost.yaml" <<'YAML'
name: lost
path: {position: [0, 0, 0], target: [1, 0, 0], extent_m: 0.1}
textures: {photo: {file: lost.png}}
objects: [{kind: quad, corner: [1, 1, 1], right: [0, -2, 0], down: [0, 0, -2], texture: photo}]
YAML
cat >"$work/mesh.yaml" <<'YAML'
name: mesh
path: {position: [0, 0, 0], target: [1, 0, 0], extent_m: 0.1}
textures: {}
objects: [{kind: mesh, file: broken.obj, position: [0, 0, 0]}]
YAML
echo "no mesh at all" >"$work/broken.obj"
sed 's/broken.obj/far.obj/' "$work/mesh.yaml" >"$work/far_mesh.yaml"
printf 'v 0 0 0\nv 1 0 0\nv 1e39 1 0\nf 1 2 3\n' >"$work/far.obj"
sed 's/objects:.*/objects: [{kind: box, position: [0, 0, -1], size: [2, 2, 2], texture: white}]/
  s/textures:.*/textures: {white: {kind: white, pixels: 16}}/' "$work/mesh.yaml" >"$work/inside.yaml"
sed 's/position: \[0, 0, -1\]/position: [1.0e+38, 0, 0]/' "$work/inside.yaml" >"$work/far.yaml"
echo "0 0 0 nan 0 0 0 1" >"$work/nan.txt"
echo "0 1e30 0 0 0 0.7071068 0 0.7071068" >"$work/far.txt"
echo "0 -0.005 0 0 0 0.7071068 0 0.7071068" >"$work/touching.txt"

expect_error "missing texture" "lost.png" \
  "$program" --scene="$work/lost.yaml" --camera="$camera" --output_dir="$work/a"
expect_error "mesh that does not load" "broken.obj" \
  "$program" --scene="$work/mesh.yaml" --camera="$camera" --output_dir="$work/a"
expect_error "mesh with a vertex out of range" "far.obj" \
  "$program" --scene="$work/far_mesh.yaml" --camera="$camera" --output_dir="$work/a"
expect_error "object out of sight" "far.yaml" \
  "$program" --scene="$work/far.yaml" --camera="$camera" --output_dir="$work/a"
expect_error "camera inside an object" "inside an object" \
  "$program" --scene="$work/inside.yaml" --camera="$camera" --output_dir="$work/a"
expect_error "unknown scene" "attic" \
  "$program" --scene=attic --camera="$camera" --output_dir="$work/a"
expect_error "trajectory with NaN" "nan.txt" \
  "${plane[@]}" --trajectory="$work/nan.txt" --output_dir="$work/a"
expect_error "trajectory out of sight" "far.txt" \
  "${plane[@]}" --trajectory="$work/far.txt" --output_dir="$work/a"
expect_error "camera that touches a surface" "touching.txt" \
  "${plane[@]}" --trajectory="$work/touching.txt" --output_dir="$work/a"
expect_error "unknown trajectory" "--trajectory" \
  "${plane[@]}" --trajectory=waltz --output_dir="$work/a"
expect_error "no camera" "--camera" "$program" --output_dir="$work/a"
expect_error "bits" "4 bits" "${plane[@]}" --bits=4 --output_dir="$work/a"
expect_error "extent" "--extent_m" "${plane[@]}" --extent_m=nan --output_dir="$work/a"
expect_error "threads" "--threads" "${plane[@]}" --threads=-1 --output_dir="$work/a"
if [ -e "$work/a" ]; then echo "FAIL: bad input left a folder"; failures=$((failures + 1)); fi

# A full disk, played by a limit on the size of files (its signal ignored, so that writing fails).
full_disk() { (trap '' XFSZ; ulimit -f 16; "${plane[@]}" --output_dir="$work/full"); }
expect_error "full disk" "space left" full_disk
if [ -e "$work/full/raw.txt" ]; then echo "FAIL full disk: raw.txt says it is complete"; failures=1; fi

for image in $(find "$work/full" -name '*.png'); do
  if [ "$(tail -c 8 "$image" | head -c 4)" != IEND ]; then
    echo "FAIL full disk: $image is cut off"; failures=$((failures + 1))
  fi
done

# The run goes on once there is space.
if ! "${plane[@]}" --output_dir="$work/full" >"$work/out" 2>&1 || [ ! -e "$work/full/raw.txt" ]; then
  echo "FAIL resume:"; cat "$work/out"; failures=$((failures + 1))
fi

# The same pixels on one thread and on two, and in a run that was not interrupted.
"${plane[@]}" --threads=1 --output_dir="$work/one" >"$work/out" 2>&1
"${plane[@]}" --threads=2 --output_dir="$work/two" >"$work/out" 2>&1
for other in "$work/two" "$work/full"; do
  if ! diff -r "$work/one" "$other"; then
    echo "FAIL: $other differs from a run on one thread"; failures=$((failures + 1))
  fi
done

if ! "$program" --version | grep -q '^prism_simulate [0-9.]* (.*)$'; then
  echo "FAIL: --version"; failures=$((failures + 1))
fi

echo "$failures failure(s)"
exit $((failures > 0))
