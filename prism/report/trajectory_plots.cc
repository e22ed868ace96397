// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/trajectory_plots.h"

#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>

#include "prism/eval/association.h"
#include "prism/eval/series.h"

namespace prism {
namespace {

// Directions of the drawings in the world of the ground truth: along, across, up.
Eigen::Matrix3d DrawingAxes(const Trajectory& groundtruth) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const StampedPose& pose : groundtruth) {
    mean += pose.world_from_cam.translation() / static_cast<double>(groundtruth.size());
    up -= pose.world_from_cam.rotation() * Eigen::Vector3d::UnitY();
  }
  up = up.norm() > 1e-6 ? Eigen::Vector3d(up.normalized()) : Eigen::Vector3d(0, 0, 1);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const StampedPose& pose : groundtruth) {
    Eigen::Vector3d offset = pose.world_from_cam.translation() - mean;
    offset -= offset.dot(up) * up;
    covariance += offset * offset.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  Eigen::Vector3d along = solver.eigenvectors().col(2);
  along -= along.dot(up) * up;
  along = along.norm() > 1e-6 ? Eigen::Vector3d(along.normalized()) : up.unitOrthogonal();
  Eigen::Matrix3d axes;
  axes << along, up.cross(along), up;
  return axes;
}

PlotSeries Project(const Trajectory& trajectory,
                   const SE3& gt_from_world,
                   const Eigen::Vector3d& x_axis,
                   const Eigen::Vector3d& y_axis,
                   const std::string& label) {
  PlotSeries series;
  series.label = label;
  series.points.reserve(trajectory.size());
  for (const StampedPose& pose : trajectory) {
    const Eigen::Vector3d position = gt_from_world * pose.world_from_cam.translation();
    series.points.push_back({x_axis.dot(position), y_axis.dot(position)});
  }
  return series;
}

PlotSeries OverTime(const std::vector<TimedValue>& values,
                    int64_t start_ns,
                    const std::string& label) {
  PlotSeries series;
  series.label = label;
  for (const TimedValue& value : values) {
    series.points.push_back({1e-9 * static_cast<double>(value.time_ns - start_ns), value.value});
  }
  return series;
}

}  // namespace

std::vector<NamedPlot> MakeTrajectoryPlots(const Trajectory& groundtruth,
                                           const std::vector<EvaluatedTrajectory>& estimates,
                                           const EvaluationOptions& options) {
  const Eigen::Matrix3d axes = DrawingAxes(groundtruth);
  Plot above{"Trajectory from above", "along (m)", "across (m)", {}, true, false};
  Plot side{"Trajectory from the side", "along (m)", "up (m)", {}, true, false};
  Plot error{"Position error after SE3 alignment", "time (s)", "error (m)", {}, false, true};
  Plot scale{"Scale in a window of 3 s", "time (s)", "scale", {}, false, false};

  above.series.push_back(Project(groundtruth, SE3(), axes.col(0), axes.col(1), "ground truth"));
  side.series.push_back(Project(groundtruth, SE3(), axes.col(0), axes.col(2), "ground truth"));
  const int64_t start_ns = groundtruth.front().time_ns;
  const double duration_s = 1e-9 * static_cast<double>(groundtruth.back().time_ns - start_ns);
  scale.series.push_back({"ground truth", {{0, 1}, {duration_s, 1}}});
  for (Plot* plot : {&above, &side, &scale}) plot->series[0].is_reference = true;

  for (const EvaluatedTrajectory& entry : estimates) {
    if (entry.metrics.status != EvaluationStatus::kDone) continue;
    const SE3& gt_from_estimate = entry.metrics.gt_from_estimate;
    above.series.push_back(
        Project(entry.estimate, gt_from_estimate, axes.col(0), axes.col(1), entry.label));
    side.series.push_back(
        Project(entry.estimate, gt_from_estimate, axes.col(0), axes.col(2), entry.label));
    const int64_t tolerance_ns = options.max_time_difference_ns > 0
                                     ? options.max_time_difference_ns
                                     : HalfFrame(groundtruth, entry.estimate);
    const std::vector<PosePair> pairs = Associate(groundtruth, entry.estimate, tolerance_ns);
    error.series.push_back(OverTime(ErrorOverTime(pairs, gt_from_estimate), start_ns, entry.label));
    scale.series.push_back(OverTime(ScaleOverTime(pairs), start_ns, entry.label));
  }
  return {{"trajectory_above", std::move(above)},
          {"trajectory_side", std::move(side)},
          {"error", std::move(error)},
          {"scale", std::move(scale)}};
}

}  // namespace prism
