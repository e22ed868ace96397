// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include "prism/factors/default_terms.h"
#include "prism/window/optimize.h"
#include "test/window/synthetic_window.h"

namespace prism {
namespace {

// One optimisation of 7 keyframes, 2000 points, 6 iterations; the argument is the thread count.
void BM_OptimizeWindow(benchmark::State& state) {
  Window window = MakeSyntheticWindow({});
  WindowOptions options;
  options.solve.threads = static_cast<int>(state.range(0));
  options.solve.max_iterations = 6;
  options.solve.function_tolerance = 0;  // all of them
  const TermList terms = MakeDefaultTerms({});
  OptimizationResult result;
  for (auto _ : state) {
    state.PauseTiming();
    PerturbWindow(0.002, 0.001, 0.03, &window);
    state.ResumeTiming();
    result = OptimizeWindow(options, terms, &window);
  }
  state.counters["iterations"] = result.solve.iterations;
  state.counters["patterns"] = result.terms[0].factors;
}
BENCHMARK(BM_OptimizeWindow)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace prism

BENCHMARK_MAIN();
