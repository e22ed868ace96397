#!/usr/bin/env bash
# Installs, builds, and runs PRISM-VO. Without an argument it renders a sequence first: a loop
# through a furnished room, seen by a Raytrix camera with a 16 mm lens. A second call reuses its
# frames. With a sequence folder as argument it runs on that:
#   bash tools/demo.sh [SEQUENCE [CAMERA]]
set -euo pipefail
cd "$(dirname "$0")/.."

bash tools/install_deps.sh
mkdir -p build
cmake --workflow --preset release >build/demo.log 2>&1 || { tail -n 40 build/demo.log; exit 1; }
bin=build/release/bin

if [ $# -ge 1 ]; then
  sequence=$1
  output=out/$(basename "$sequence")
  camera=${2:-}
else
  sequence=out/demo/sequence
  output=out/demo/result
  camera=
  "$bin/prism_simulate" --scene=room --trajectory=loop --frames=60 --extent_m=0.25 --replace \
    --camera=calib/raytrix_r5_16mm.yaml --output_dir="$sequence"
fi

# The sequence's own calibration, unless one was given.
grid=()
for file in camera.yaml CameraModel.xml; do
  [ -z "$camera" ] && [ -e "$sequence/$file" ] && camera=$sequence/$file
done
# RGB-D: the lenses to stand in for; the pinhole is in the sequence's calibration.txt.
[ -z "$camera" ] && [ -e "$sequence/calibration.txt" ] && camera=calib/raytrix_r5_16mm.yaml
[ -e "$sequence/MLA_Calibration.xml" ] && grid=("--micro_lens_grid=$sequence/MLA_Calibration.xml")
[ -n "$camera" ] && camera=--camera=$camera

"$bin/prism_vo" --sequence="$sequence" ${camera:+"$camera"} "${grid[@]}" --output_dir="$output"

if [ -e "$sequence/groundtruth.txt" ]; then
  "$bin/prism_eval" --groundtruth="$sequence/groundtruth.txt" --estimate="$output/trajectory.txt"
fi
echo "results: $output (open $output/report.html)"
