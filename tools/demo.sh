#!/usr/bin/env bash
# Installs, builds, and runs PRISM-VO. Without an argument it renders a sequence first: a loop
# through a furnished room, seen by a Raytrix camera with a 16 mm lens. A second call reuses its
# frames. With a sequence folder as argument it runs on that, with what calibration is in it:
#   bash tools/demo.sh [SEQUENCE [FLAGS OF prism_vo]]
set -euo pipefail
cd "$(dirname "$0")/.."

bash tools/install_deps.sh
mkdir -p build
echo "building; what it says goes to build/demo.log"
cmake --workflow --preset release >build/demo.log 2>&1 || { tail -n 40 build/demo.log; exit 1; }
bin=build/release/bin

if [ $# -ge 1 ]; then
  sequence=$1
  output=out/$(basename "$sequence")
  shift
else
  sequence=out/demo/sequence
  output=out/demo/result
  "$bin/prism_simulate" --scene=room --trajectory=loop --frames=30 --rate_hz=8 --extent_m=0.25 --replace \
    --camera=calib/raytrix_r5_16mm.yaml --output_dir="$sequence"
fi

"$bin/prism_vo" --sequence="$sequence" --output_dir="$output" "$@"
if [ -e "$sequence/groundtruth.txt" ]; then
  "$bin/prism_eval" --groundtruth="$sequence/groundtruth.txt" --estimate="$output/trajectory.txt"
fi
echo "results: $output (open $output/report.html)"
