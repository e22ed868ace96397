#!/bin/bash
# Renders the sequences of house_mesh.yaml: six paths through a scanned house, with micro lenses of
# one focal length and of three. About 3 s a frame on 2 cores, 600 frames in all.
#   sequences/render_house_mesh.sh FOLDER_OF_HOUSE_MESH OUTPUT_FOLDER [BUILD_FOLDER]
set -euo pipefail
cd "$(dirname "$0")/.."
house=${1:?folder with scene.yaml and trajectories/} out=${2:?folder to write to} build=${3:-build/release}
for path in kitchen sofa living door counter turn; do
  for types in one three; do
    camera=calib/raytrix_r5_16mm.yaml
    if [ "$types" = one ]; then camera=sequences/cameras/raytrix_r5_16mm_one_type.yaml; fi
    "$build"/bin/prism_simulate --scene="$house/scene.yaml" \
      --trajectory="$house/trajectories/$path.txt" --camera=$camera \
      --output_dir="$out/$path.$types" --truth_every=1000
  done
done
