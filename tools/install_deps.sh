#!/usr/bin/env bash
# Installs the Debian packages PRISM-VO is built with, those that are missing only.
# With everything in place it costs well under a second and needs no privileges.
#   tools/install_deps.sh [--with-browser]   also Chromium (some 120 MB), which the tests of the
#                                            report page drive; without it they are skipped
set -euo pipefail

packages=(
  build-essential cmake ninja-build ccache git clang-format
  libceres-dev libeigen3-dev libopencv-dev libgoogle-glog-dev libgflags-dev
  libgtest-dev libgmock-dev libbenchmark-dev
  libyaml-cpp-dev libpugixml-dev nlohmann-json3-dev
  libembree-dev libtbb-dev libhwy-dev libassimp-dev
  libjs-three libjs-dygraphs libcpp-httplib-dev libcairo2-dev pkg-config
)

install_missing() {
  local missing=() as_root=()
  for package in "$@"; do
    [ -e "/var/lib/dpkg/info/$package.list" ] ||
      ls /var/lib/dpkg/info/"$package":*.list >/dev/null 2>&1 || missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return 0

  echo "installing: ${missing[*]}"
  [ "$(id -u)" -eq 0 ] || as_root=(sudo)
  "${as_root[@]}" apt-get update -qq
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y -qq --no-install-recommends "${missing[@]}"
}

install_missing "${packages[@]}"
if [ "${1:-}" = --with-browser ]; then
  # Ubuntu has Chromium as a snap only: no reason to fail.
  install_missing chromium chromium-driver ||
    echo "no Chromium here: tests that need a browser will be skipped"
fi
