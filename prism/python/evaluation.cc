// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/python/evaluation.h"

#include <pybind11/numpy.h>

#include "prism/eval/metrics.h"
#include "prism/python/frames.h"

namespace prism {
namespace {

namespace py = pybind11;

py::dict Evaluate(const py::array_t<double>& groundtruth, const py::array_t<double>& estimate) {
  const TrajectoryMetrics metrics =
      EvaluateTrajectory(TrajectoryOf(groundtruth), TrajectoryOf(estimate));
  py::dict result;
  result["status"] = ToString(metrics.status);
  result["matched_count"] = metrics.matched_count;
  result["coverage_percent"] = metrics.coverage_percent;
  result["path_length_m"] = metrics.path_length_m;
  if (metrics.status != EvaluationStatus::kDone) return result;
  result["ate_rmse_m"] = metrics.ate_rmse_m;
  result["ate_median_m"] = metrics.ate_median_m;
  result["ate_max_m"] = metrics.ate_max_m;
  if (metrics.sim3) {
    result["ate_rmse_sim3_m"] = metrics.sim3->ate_rmse_m;
    result["scale"] = metrics.sim3->scale;
    result["scale_error_percent"] = metrics.sim3->scale_error_percent;
  }
  return result;
}

}  // namespace

void BindEvaluation(py::module_* module) {
  module->def("evaluate",
              &Evaluate,
              py::arg("groundtruth"),
              py::arg("estimate"),
              "Errors of a trajectory, rows as those of Odometry.trajectory, by the names of "
              "metrics.json.");
}

}  // namespace prism
