// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "prism/odometry/odometry.h"
#include "prism/report/run_report.h"
#include "tools/run_record.h"

namespace prism {

// Title and options of a run that has not begun.
RunReport DescribeRun(const RunRecord& record);

// Collects what report.html shows while a run goes on. Keyframes are kept as small images and
// points, so that the window may forget them.
class ReportRecorder {
 public:
  // To be called after every Odometry::Process.
  void Add(const FrameResult& frame, const Odometry& odometry);

  // What has come since the last call, for LiveView; poses are those of the moment.
  nlohmann::json TakeUpdate();

  // The report of a finished run. `groundtruth` may be empty.
  RunReport Finish(const RunRecord& record,
                   const Odometry& odometry,
                   const Trajectory& groundtruth) const;

 private:
  std::map<std::string, double> TakeStageTimes(const StageTimer& timer);
  void UpdateKeyframes(const Window& window);

  std::vector<ReportFrame> frames_;
  // By keyframe id; points and poses as they were when the window last held the keyframe.
  std::map<int, ReportKeyframe> keyframes_;
  std::vector<Eigen::Vector3d> positions_;  // of the tracked frames, as tracked
  size_t frames_taken_ = 0;                 // by TakeUpdate
  size_t positions_taken_ = 0;
  int last_keyframe_taken_ = -1;
  std::map<std::string, size_t> times_taken_;  // of each stage of the timer
};

}  // namespace prism
