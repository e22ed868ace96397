// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/metrics_json.h"

#include <gtest/gtest.h>

#include "test/eval/test_trajectory.h"

namespace prism {
namespace {

TEST(MetricsJson, HasAllKeysAndNullForWhatIsMissing) {
  const Trajectory truth = CurvedTrajectory(300);
  for (const auto& json : {MetricsToJson(EvaluateTrajectory(truth, truth)),
                           MetricsToJson(EvaluateTrajectory(truth, {}))}) {
    for (const char* key : {"ate_rmse_m",
                            "ate_rmse_sim3_m",
                            "scale",
                            "scale_error_percent",
                            "rpe_trans_rmse_m",
                            "rpe_rot_rmse_deg",
                            "path_length_m",
                            "coverage_percent",
                            "e_s",
                            "e_r_deg",
                            "e_align_m"}) {
      EXPECT_TRUE(json.contains(key)) << key;
    }
  }
  EXPECT_TRUE(MetricsToJson(EvaluateTrajectory(truth, {}))["ate_rmse_m"].is_null());
  EXPECT_TRUE(MetricsToJson(EvaluateTrajectory(truth, truth))["e_align_m"].is_number());
  Trajectory resting = truth;
  for (StampedPose& pose : resting) pose.world_from_cam = SE3();
  EXPECT_TRUE(MetricsToJson(EvaluateTrajectory(truth, resting))["scale"].is_null());
}

}  // namespace
}  // namespace prism
