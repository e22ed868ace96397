#!/usr/bin/env bash
# The tests of what runs in threads, under ThreadSanitizer (preset tsan); some ten minutes on two cores.
# It has to see how TBB hands work over, so that TBB is built with it first, from Debian's source:
# apt needs deb-src among its types of sources.
set -euo pipefail
cd "$(dirname "$0")/.."

tests=(report_test run_test io_test lightfield_test odometry_test)
tbb=$PWD/build/tsan/tbb
if ! compgen -G "$tbb/build/*/libtbb.so.12" > /dev/null; then
  mkdir -p "$tbb"
  (cd "$tbb" && apt-get source -qq --download-only onetbb &&
    tar --strip-components=1 -xf onetbb_*.orig.tar.*)
  cmake -S "$tbb" -B "$tbb/build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DTBB_TEST=OFF \
    -DTBB_STRICT=OFF -DTBB_SANITIZE=thread > /dev/null
  ninja -C "$tbb/build" tbb
fi
cmake --preset tsan > /dev/null
cmake --build --preset tsan --target "${tests[@]}"
library=$(compgen -G "$tbb/build/*/libtbb.so.12")
export LD_LIBRARY_PATH=$(dirname "$library")
export TSAN_OPTIONS=suppressions=$PWD/test/tsan_suppressions.txt
for test in "${tests[@]}"; do build/tsan/bin/"$test" --gtest_brief=1; done
