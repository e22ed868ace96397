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

// Collects what report.html shows while a run goes on. Keyframes are kept as small images and
// points, so that the window may forget them.
class ReportRecorder {
 public:
  // To be called after every Odometry::Process.
  void Add(const FrameResult& frame, const Odometry& odometry);

  const std::vector<ReportFrame>& frames() const { return frames_; }
  // By keyframe id; points and poses as they were when the window last held the keyframe.
  const std::map<int, ReportKeyframe>& keyframes() const { return keyframes_; }

  // The report of a finished run. `groundtruth` may be empty.
  RunReport Finish(const RunRecord& record,
                   const Odometry& odometry,
                   const Trajectory& groundtruth) const;

 private:
  std::map<std::string, double> TakeStageTimes(const StageTimer& timer);
  void UpdateKeyframes(const Window& window);

  std::vector<ReportFrame> frames_;
  std::map<int, ReportKeyframe> keyframes_;
  std::map<std::string, size_t> times_taken_;  // of each stage of the timer
};

}  // namespace prism
