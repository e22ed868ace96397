// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <future>
#include <map>
#include <string>
#include <vector>

#include "prism/export/export_run.h"
#include "prism/odometry/odometry.h"
#include "prism/report/live_view.h"
#include "prism/report/run_report.h"
#include "tools/run_record.h"

namespace prism {

// Title and options of a run that has not begun.
RunReport DescribeRun(const RunRecord& record);

// Collects what report.html shows while a run goes on. Keyframes are kept as small images and depth
// maps, which are encoded in threads of their own, and points, so that the window may forget them.
// Of long runs every second, fourth, ... of those that have left the window keeps these, the others
// their poses. At the end the depth maps are fused to one cloud.
class ReportRecorder {
 public:
  static constexpr size_t kMaxPictures = 200;  // beside those of the window

  // To be called after every Odometry::Process. `reading`: times of reading and preparing frames,
  // this one the last of them.
  void Add(const FrameResult& frame, const Odometry& odometry, const StageTimer& reading);

  // What has come since the last call, for LiveView; poses are those of the moment. Keyframes whose
  // pictures are not encoded yet come with a later one, unless this `is_last`.
  RunUpdate TakeUpdate(bool is_last = false);

  // The report of a finished run. `groundtruth` may be empty.
  RunReport Finish(const RunRecord& record,
                   const Odometry& odometry,
                   const Trajectory& groundtruth) &&;

 private:
  // What is made of a keyframe's frame.
  struct Pictures {
    ReportKeyframe keyframe;  // image and depth maps only
    ExportKeyframe depth;     // for FuseDepth, on the pixels of the depth maps
  };

  // Pose as it was when the window last held the keyframe. Points as they were when it last had at
  // least half of the most it ever had: later ones are what marginalisation has left.
  struct Entry {
    ReportKeyframe keyframe;  // without pictures until they are taken
    ExportKeyframe depth;
    size_t most_points = 0;
    std::future<Pictures> pictures;
    bool is_told = false;      // by TakeUpdate
    bool has_changed = false;  // since it was told
  };

  void UpdateKeyframes(const Odometry& odometry);
  void ThinOutPictures(const Window& window);
  // After a segment was joined to another, or moved since.
  void MoveKeyframes(const Map& map);
  static Pictures MakePictures(const LightFieldFrame& frame);
  // Moves the pictures into the entry once they are encoded; waits for that if asked to. False: not
  // there yet.
  static bool TakePictures(bool wait, Entry* entry);
  // Each piece of the map on its own. Pictures must have been taken.
  std::vector<ReportCloudPoint> FuseDepthMaps(const RunRecord& record, const Map& map) const;

  std::vector<ReportFrame> frames_;
  std::map<int, Entry> keyframes_;          // by id
  size_t picture_step_ = 1;                 // every so many of them keep pictures and points
  std::vector<Eigen::Vector3d> positions_;  // of the tracked frames, as tracked
  size_t frames_taken_ = 0;                 // by TakeUpdate
  size_t positions_taken_ = 0;
  size_t problems_taken_ = 0;
  std::map<std::string, double> reading_totals_, odometry_totals_;  // see TakeNewTimes
};

}  // namespace prism
