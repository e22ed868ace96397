// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "prism/base/stage_timer.h"
#include "prism/camera/plenoptic_camera.h"
#include "prism/odometry/odometry.h"

namespace prism {

// What run.json holds.
struct RunRecord {
  std::map<std::string, std::string> options;
  std::string camera_path;
  PlenopticCamera camera;
  std::string sequence_format;
  std::vector<FrameResult> frames;
  Trajectory trajectory;  // of the tracked ones, as known at the end; times as in `frames`
  std::map<std::string, StageTimer::Summary> stages;
  double wall_seconds = 0;
  double intensity_sigma = 0;  // photometric residuals are weighted by it, at the end
  double depth_scale = 1;      // and measured 1/v by this times their stated sigma
};

int CountTracked(const std::vector<FrameResult>& frames);
int CountKeyframes(const std::vector<FrameResult>& frames);

// Times of the first tracked frame of every segment but the first, ns.
std::vector<int64_t> SegmentStarts(const std::vector<FrameResult>& frames);

// Largest resident set of this process so far, MiB.
double PeakResidentMib();

nlohmann::ordered_json RunToJson(const RunRecord& record);

}  // namespace prism
