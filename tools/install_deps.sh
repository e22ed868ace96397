#!/usr/bin/env bash
# Installs the Debian packages PRISM-VO is built with, those that are missing only.
# With everything in place it costs well under a second and needs no privileges.
#   --with-browser   also Chromium (some 120 MB), which the tests of the report page drive
#   --with-readers   also COLMAP, @mcap/core, and OpenCV and matplotlib for Python (some 100 MB), which
#                    the tests of the exports and of the Python module read and plot with
#   --with-lint      also clang-tidy (some 100 MB), for tools/lint.sh
# Without the first two some tests are skipped, or read with less.
set -euo pipefail

packages=(
  build-essential cmake ninja-build ccache git clang-format cppcheck
  libceres-dev libeigen3-dev libopencv-dev libgoogle-glog-dev libgflags-dev
  libgtest-dev libgmock-dev libbenchmark-dev
  libyaml-cpp-dev libpugixml-dev nlohmann-json3-dev
  libembree-dev libtbb-dev libhwy-dev libassimp-dev
  libjs-three libjs-dygraphs libcpp-httplib-dev libcairo2-dev pkg-config
  libprotobuf-dev protobuf-compiler
  pybind11-dev python3-dev python3-numpy
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
for option in "$@"; do
  case "$option" in
    --with-browser)
      # Ubuntu has Chromium as a snap only: no reason to fail.
      install_missing chromium chromium-driver ||
        echo "no Chromium here: tests that need a browser will be skipped"
      ;;
    --with-readers)
      readers="$(dirname "$0")/../test/export"
      install_missing colmap python3-opencv python3-matplotlib
      command -v npm >/dev/null || install_missing nodejs npm
      # Without a network there is no reason to fail either.
      [ -d "$readers/node_modules/@mcap/core" ] ||
        npm ci --silent --ignore-scripts --prefix "$readers" ||
        echo "no @mcap/core here: MCAP files will be read with less"
      ;;
    --with-lint)
      install_missing clang-tidy
      ;;
    *)
      echo "install_deps.sh: found '$option', expected --with-browser, --with-readers, --with-lint" >&2
      exit 2
      ;;
  esac
done
