// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "prism/base/stage_timer.h"
#include "prism/camera/plenoptic_camera.h"
#include "prism/lightfield/verdict.h"
#include "prism/odometry/odometry.h"

namespace prism {

// What run.json holds.
struct RunRecord {
  std::string end = "running";  // then "complete", "interrupted" or "failed"
  std::string end_reason;       // of the latter two
  std::map<std::string, std::string> options;
  std::string camera_path;
  PlenopticCamera camera;
  std::string sequence_format;
  std::vector<std::string> input_report;  // what was found and assumed (Sequence)
  LightFieldVerdict light_field;          // of raw sequences
  std::vector<std::string> notes;         // what is wrong with the sequence's lists
  std::vector<FrameResult> frames;
  std::map<int64_t, std::string> unreadable;  // by time: why
  Trajectory trajectory;  // of the tracked ones, as known at the end; times as in `frames`
  std::map<int, int> piece_of_segment;  // of the map, at the end (Map)
  std::map<std::string, StageTimer::Summary> stages;
  double wall_seconds = 0;                 // from the first frame asked for to the last result
  double processor_seconds = 0;            // in this time, of all threads, user and system
  double intensity_sigma = 0;              // photometric residuals are weighted by it, at the end
  double depth_scale = 1;                  // and measured 1/v by this times their stated sigma
  double keyframe_depth_offset_sigma = 0;  // NoiseModel::DepthOffsetSigma, at the end
  double depth_offset_prior_sigma = 0;     // DepthOffsetTermOptions; 0: not estimated
};

// What a run knows of its metric scale.
struct ScaleSummary {
  // Relative standard deviation of the length of the whole path: the mean over the keyframes'
  // windows, weighted by the length of the step that each of them added. As if the errors of all
  // windows were one, which those of a lasting offset are.
  double sigma = 0;
  double depth_offset = 0;  // of the last window, 1/v
  double depth_offset_sigma = 0;
  // The scene told scale and offset of 1/v apart: sigma of the offset below 0.7 of its prior's.
  bool is_offset_told = false;
};
// Nothing if no window was solved.
std::optional<ScaleSummary> SummarizeScale(const RunRecord& record);

int CountTracked(const std::vector<FrameResult>& frames);
int CountKeyframes(const std::vector<FrameResult>& frames);

// Times of the first tracked frame of every segment but the first, ns.
std::vector<int64_t> SegmentStarts(const std::vector<FrameResult>& frames);

// Processor time of this process so far, all threads, user and system.
double ProcessorSeconds();

// Largest resident set of this process so far, MiB.
double PeakResidentMib();

// run.json: a line for each frame, in the order they came.
void WriteJson(const RunRecord& record, std::ostream& stream);

}  // namespace prism
