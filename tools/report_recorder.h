// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <future>
#include <map>
#include <string>
#include <vector>

#include "prism/odometry/odometry.h"
#include "prism/report/live_view.h"
#include "prism/report/run_report.h"
#include "tools/run_record.h"

namespace prism {

// Title and options of a run that has not begun.
RunReport DescribeRun(const RunRecord& record);

// Collects what report.html shows while a run goes on. Keyframes are kept as small images, which
// are encoded in threads of their own, and points, so that the window may forget them. Of long runs
// every second, fourth, ... of those that have left the window keeps its image and points, the
// others their poses.
class ReportRecorder {
 public:
  static constexpr size_t kMaxPictures = 200;  // beside those of the window

  // To be called after every Odometry::Process. `reading`: times of reading and preparing frames,
  // this one the last of them.
  void Add(const FrameResult& frame, const Odometry& odometry, const StageTimer& reading);

  // What has come since the last call, for LiveView; poses are those of the moment.
  RunUpdate TakeUpdate();

  // The report of a finished run. `groundtruth` may be empty.
  RunReport Finish(const RunRecord& record,
                   const Odometry& odometry,
                   const Trajectory& groundtruth);

 private:
  // Pose as it was when the window last held the keyframe. Points as they were when it last had at
  // least half of the most it ever had: later ones are what marginalisation has left.
  struct Entry {
    ReportKeyframe keyframe;  // without image until `thumbnail` is taken
    size_t most_points = 0;
    std::future<ReportKeyframe> thumbnail;  // image and size only
    bool is_told = false;                   // by TakeUpdate
    bool has_changed = false;               // since it was told
  };

  void UpdateKeyframes(const Odometry& odometry);
  void ThinOutPictures(const Window& window);
  // After a segment was joined to another.
  void MoveKeyframes(const Map& map);
  // Moves the image into the keyframe once it is encoded; waits for that if asked to. False: not
  // there yet.
  static bool TakeThumbnail(bool wait, Entry* entry);

  std::vector<ReportFrame> frames_;
  std::map<int, Entry> keyframes_;          // by id
  size_t picture_step_ = 1;                 // every so many of them keep image and points
  std::vector<Eigen::Vector3d> positions_;  // of the tracked frames, as tracked
  size_t frames_taken_ = 0;                 // by TakeUpdate
  size_t positions_taken_ = 0;
  size_t problems_taken_ = 0;
  std::map<std::string, double> reading_totals_, odometry_totals_;  // see TakeNewTimes
};

}  // namespace prism
