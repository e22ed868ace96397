// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>

#include "prism/eval/metrics.h"

namespace prism {

// What metrics.json holds: status, matched_count, groundtruth_count, estimate_count,
// coverage_percent, path_length_m, ate_rmse_m, ate_median_m, ate_max_m, ate_rmse_sim3_m, scale,
// scale_error_percent, d_s, rpe_trans_rmse_m, rpe_rot_rmse_deg, rpe_over_distance
// [{distance_m, trans_rmse_m, rot_rmse_deg, count}], e_s, e_r_deg, e_align_m and segments
// [{start_s, end_s, matched_count, path_length_m, ate_rmse_m, scale}].
// What could not be computed is null; all keys are always there.
nlohmann::ordered_json MetricsToJson(const TrajectoryMetrics& metrics);

}  // namespace prism
