// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>

#include <tbb/task_arena.h>

namespace prism {

// Runs `work` and returns its result; the parallel loops in it (TBB) use at most `threads` threads,
// that of the caller included; 0: one a core. An arena of its own, so that what else the program
// does with TBB is not limited. OpenCV has threads of its own (cv::setNumThreads).
template <typename Work>
auto WithThreads(int threads, Work&& work) {
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  return arena.execute(std::forward<Work>(work));
}

}  // namespace prism
