// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// Inputs that once ended a reader in another way than by InputError, and the seeds they came from.
#include <filesystem>

#include <gtest/gtest.h>

#include "prism/io/atomic_file.h"
#include "test/fuzz/targets.h"

namespace prism {
namespace {

namespace fs = std::filesystem;

TEST(Fuzz, NoKnownInputEndsAReader) {
  for (const auto& [name, target] : FuzzTargets()) {
    const fs::path folder = fs::path(PRISM_SOURCE_DIR) / "test/fuzz/seeds" / name;
    int count = 0;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
      SCOPED_TRACE(entry.path().string());
      EXPECT_NO_THROW(target(ReadTextFile(entry.path().string())));
      ++count;
    }
    EXPECT_GT(count, 0) << name;
  }
}

}  // namespace
}  // namespace prism
