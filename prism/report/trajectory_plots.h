// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "prism/eval/metrics.h"
#include "prism/report/plot.h"

namespace prism {

// An estimate with what EvaluateTrajectory said of it.
struct EvaluatedTrajectory {
  std::string label;
  std::string path;
  Trajectory estimate;
  TrajectoryMetrics metrics;
};

struct NamedPlot {
  std::string name;  // of the file, without extension
  Plot plot;
};

// Four plots of any number of estimates against one ground truth; estimates whose metrics are not
// done are left out. Positions are those after SE3 alignment, times are since the first true pose.
//   trajectory_above  from above: the two axes of the ground truth's world with the most motion in
//                     the horizontal plane of its cameras
//   trajectory_side   the first of these axes, and height
//   error             distance from the true position over time
//   scale             scale in a sliding window over time
// "Above" is along the mean direction of the cameras' y axis (down), so that it does not matter
// which way the world of the ground truth is turned.
std::vector<NamedPlot> MakeTrajectoryPlots(const Trajectory& groundtruth,
                                           const std::vector<EvaluatedTrajectory>& estimates,
                                           const EvaluationOptions& options);

}  // namespace prism
