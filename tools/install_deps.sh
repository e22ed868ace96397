#!/usr/bin/env bash
# Installs the Debian packages PRISM-VO is built with, those that are missing only.
# With everything in place it costs well under a second and needs no privileges.
set -euo pipefail

packages=(
  build-essential cmake ninja-build ccache git clang-format
  libceres-dev libeigen3-dev libopencv-dev libgoogle-glog-dev libgflags-dev
  libgtest-dev libgmock-dev libbenchmark-dev
  libyaml-cpp-dev libpugixml-dev nlohmann-json3-dev
  libembree-dev libtbb-dev libhwy-dev libassimp-dev
  libjs-three libjs-dygraphs libcpp-httplib-dev
)

missing=()
for package in "${packages[@]}"; do
  [ -e "/var/lib/dpkg/info/$package.list" ] || ls /var/lib/dpkg/info/"$package":*.list >/dev/null 2>&1 ||
    missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

echo "installing: ${missing[*]}"
as_root=()
[ "$(id -u)" -eq 0 ] || as_root=(sudo)
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get install -y -qq --no-install-recommends "${missing[@]}"
