#!/usr/bin/env bash
# Feeds every reader of files with what libFuzzer makes of the seeds in test/fuzz/seeds:
#   bash tools/fuzz.sh [SECONDS_EACH | --runs=INPUTS_EACH] [TARGET ...]     a minute each, all targets
# Inputs that end a reader stay in build/fuzz/found/TARGET; one that is mended belongs into the
# target's seeds, which the test fuzz_replay reads.
set -euo pipefail
cd "$(dirname "$0")/.."

case "${1:-60}" in
  --runs=*) until=-runs=${1#--runs=} ;;
  *) until=-max_total_time=${1:-60} ;;
esac
shift || true
if ! command -v clang++ > /dev/null; then
  echo "fuzz.sh needs Clang: apt-get install clang libclang-rt-14-dev" >&2
  exit 2
fi
cmake --preset fuzz > /dev/null
cmake --build --preset fuzz --target fuzz_readers
targets=("$@")
if [ ${#targets[@]} -eq 0 ]; then
  for folder in test/fuzz/seeds/*/; do targets+=("$(basename "$folder")"); done
fi
status=0
for target in "${targets[@]}"; do
  found=build/fuzz/found/$target corpus=build/fuzz/corpus/$target
  mkdir -p "$found" "$corpus"
  echo "== $target"
  PRISM_FUZZ_TARGET=$target build/fuzz/bin/fuzz_readers "$until" -timeout=10 \
    -rss_limit_mb=3000 -max_len=8192 -artifact_prefix="$found/" -print_final_stats=1 -verbosity=0 \
    "$corpus" "test/fuzz/seeds/$target" > "$found/log.txt" 2>&1 || status=1
  grep -aE "number_of_executed_units|ERROR|SUMMARY|Test unit|runtime error" "$found/log.txt" || true
done
exit $status
