#!/usr/bin/env bash
# Static analysis of library, programs and tests; a remark is an error.
#   bash tools/lint.sh          cppcheck (15 s) and clang-tidy (.clang-tidy; library and programs; half
#                               an hour on two cores)
#   bash tools/lint.sh --quick  cppcheck alone
set -euo pipefail
cd "$(dirname "$0")/.."

for tool in cppcheck $([ "${1:-}" = --quick ] || echo clang-tidy); do
  command -v "$tool" > /dev/null ||
    { echo "lint.sh needs $tool: bash tools/install_deps.sh --with-lint" >&2; exit 2; }
done
build=build/lint
cmake --preset lint > /dev/null
# Sources that are generated.
ninja -C "$build" prism_git_revision generated/report_page.cc generated/calibration_page.cc \
  generated/prism/export/foxglove/foxglove.pb.cc > /dev/null
cppcheck --project="$build/compile_commands.json" -i build --quiet -j "$(nproc)" \
  --enable=warning,performance,portability --library=googletest --error-exitcode=1
[ "${1:-}" = --quick ] ||
  run-clang-tidy -quiet -j "$(nproc)" -p "$build" "$PWD/(prism|tools)/.*\.cc$" 2> /dev/null
