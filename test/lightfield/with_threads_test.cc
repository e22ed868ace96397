// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/with_threads.h"

#include <chrono>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

namespace prism {
namespace {

// Threads that take part in a loop long enough for all to come.
size_t ThreadsOfALoop() {
  std::mutex mutex;
  std::set<std::thread::id> threads;
  tbb::parallel_for(0, 64, [&](int) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const std::lock_guard<std::mutex> lock(mutex);
    threads.insert(std::this_thread::get_id());
  });
  return threads.size();
}

TEST(WithThreads, NoMoreThreadsThanAskedForTakePart) {
  EXPECT_EQ(WithThreads(1, ThreadsOfALoop), 1u);
  EXPECT_LE(WithThreads(2, ThreadsOfALoop), 2u);
  EXPECT_LE(WithThreads(3, ThreadsOfALoop), 3u);
  EXPECT_EQ(WithThreads(3, [] { return tbb::this_task_arena::max_concurrency(); }), 3);
}

TEST(WithThreads, ZeroIsAllAndTheLimitIsNotLeftBehind) {
  const int all = tbb::this_task_arena::max_concurrency();
  EXPECT_EQ(WithThreads(0, [] { return tbb::this_task_arena::max_concurrency(); }), all);
  WithThreads(1, [] {});
  EXPECT_EQ(tbb::this_task_arena::max_concurrency(), all);
}

TEST(WithThreads, ErrorsComeThrough) {
  EXPECT_THROW(WithThreads(2, [] { throw std::runtime_error("bad grid"); }), std::runtime_error);
}

}  // namespace
}  // namespace prism
