// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/base/version.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/tools/run_program.h"

namespace prism {
namespace {

TEST(Version, IsToldByEveryProgram) {
  for (const std::string name : {"prism_bench",
                                 "prism_check_jacobians",
                                 "prism_depth_errors",
                                 "prism_eval",
                                 "prism_lightfield",
                                 "prism_vo"}) {
    const ProgramResult result = RunProgram(name + " --version");
    EXPECT_EQ(result.exit_status, 0) << name;
    EXPECT_THAT(result.output,
                testing::MatchesRegex(name + " " + kVersion + " \\([0-9a-z.-]+\\)\n"));
  }
}

}  // namespace
}  // namespace prism
