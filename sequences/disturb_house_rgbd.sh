#!/bin/bash
# Makes the sequences of disturbances.yaml from an RGB-D sequence of 120 frames (house_rgbd).
#   sequences/disturb_house_rgbd.sh FOLDER_OF_HOUSE_RGBD OUTPUT_FOLDER [BUILD_FOLDER]
set -euo pipefail
cd "$(dirname "$0")/.."
house=${1:?folder in TUM RGB-D layout} out=${2:?folder to write to} build=${3:-build/release}
disturb() {
  "$build"/bin/prism_disturb --sequence="$house" --output_dir="$out/$1" "${@:2}"
}
for first in 20 50 80; do
  disturb drop8_$first --drop --first=$first --count=8
  disturb drop15_$first --drop --first=$first --count=15
  disturb half_$first --cover_half --first=$first --count=30
done
disturb bright --exposure=2 --first=60
disturb dark --exposure=0.5 --first=60
disturb patch_from_the_start --moving_patch_m=1
disturb patch_later --moving_patch_m=2 --first=30 --count=60 --seed=1
disturb gross_depths --gross_depths=0.3
disturb kidnap --first=60 --count=10 --kidnap_to=30
disturb covered --black --first=50 --count=20
