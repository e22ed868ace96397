#!/usr/bin/env bash
# Installs what is missing, configures, builds and runs every test.
#   tools/test.sh [ctest arguments, for example -R geometry]
set -euo pipefail
cd "$(dirname "$0")/.."

bash tools/install_deps.sh --with-browser --with-readers
cmake --preset dev
cmake --build --preset dev -j "$(nproc)"
ctest --preset dev -j "$(nproc)" "$@"
