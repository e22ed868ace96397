// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/metrics_json.h"

namespace prism {
namespace {

using Json = nlohmann::ordered_json;

Json OrNull(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

Json SegmentToJson(const SegmentMetrics& segment) {
  return {{"start_s", 1e-9 * static_cast<double>(segment.start_ns)},
          {"end_s", 1e-9 * static_cast<double>(segment.end_ns)},
          {"matched_count", segment.matched_count},
          {"path_length_m", segment.path_length_m},
          {"ate_rmse_m", OrNull(segment.ate_rmse_m)},
          {"scale", OrNull(segment.scale)}};
}

Json DistanceToJson(const DistanceError& entry) {
  return {{"distance_m", entry.distance_m},
          {"trans_rmse_m", entry.error.trans_rmse_m},
          {"rot_rmse_deg", entry.error.rot_rmse_deg},
          {"count", entry.error.count}};
}

}  // namespace

Json MetricsToJson(const TrajectoryMetrics& metrics) {
  const bool done = metrics.status == EvaluationStatus::kDone;
  const auto number = [&](double value) { return done ? Json(value) : Json(); };
  const auto& sim3 = metrics.sim3;
  const auto& relative = metrics.relative_over_time;
  const auto& loop = metrics.loop;
  Json json = {{"status", ToString(metrics.status)},
               {"matched_count", metrics.matched_count},
               {"groundtruth_count", metrics.groundtruth_count},
               {"estimate_count", metrics.estimate_count},
               {"coverage_percent", metrics.coverage_percent},
               {"path_length_m", metrics.path_length_m},
               {"ate_rmse_m", number(metrics.ate_rmse_m)},
               {"ate_median_m", number(metrics.ate_median_m)},
               {"ate_max_m", number(metrics.ate_max_m)},
               {"ate_rmse_sim3_m", sim3 ? Json(sim3->ate_rmse_m) : Json()},
               {"scale", sim3 ? Json(sim3->scale) : Json()},
               {"scale_error_percent", sim3 ? Json(sim3->scale_error_percent) : Json()},
               {"d_s", sim3 ? Json(sim3->d_s) : Json()},
               {"rpe_trans_rmse_m", relative ? Json(relative->trans_rmse_m) : Json()},
               {"rpe_rot_rmse_deg", relative ? Json(relative->rot_rmse_deg) : Json()},
               {"e_s", loop ? Json(loop->e_s) : Json()},
               {"e_r_deg", loop ? Json(loop->e_r_deg) : Json()},
               {"e_align_m", loop ? Json(loop->e_align_m) : Json()}};
  json["rpe_over_distance"] = Json::array();
  for (const DistanceError& entry : metrics.relative_over_distance) {
    json["rpe_over_distance"].push_back(DistanceToJson(entry));
  }
  json["segments"] = Json::array();
  for (const SegmentMetrics& segment : metrics.segments) {
    json["segments"].push_back(SegmentToJson(segment));
  }
  return json;
}

}  // namespace prism
