// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include <gflags/gflags.h>

#include "prism/base/error.h"
#include "prism/base/random.h"
#include "prism/io/atomic_file.h"
#include "prism/io/focused_sequence.h"
#include "prism/io/image_file.h"
#include "prism/io/rgbd_sequence.h"
#include "prism/io/trajectory_file.h"
#include "prism/sim/disturbance.h"
#include "tools/tool_main.h"

DEFINE_string(sequence, "", "Folder in TUM RGB-D layout");
DEFINE_string(output_dir, "", "Folder the disturbed sequence is written to, in the same layout");
DEFINE_int32(first, 0, "First disturbed frame");
DEFINE_int32(count, 0, "Number of disturbed frames; 0: to the end");
DEFINE_bool(drop, false, "Leave these frames out");
DEFINE_double(exposure, 1, "Multiply their intensities");
DEFINE_bool(cover_half, false, "Hold a uniform sheet before the left half of the view");
DEFINE_double(moving_patch_m, 0, "Move a textured patch of a fifth of the view at this depth, m");
DEFINE_double(gross_depths, 0, "Spoil this fraction of the depths, 0 to 1");
DEFINE_bool(black, false, "A covered lens: nothing is seen but the sensor's noise");
DEFINE_int32(
    kidnap_to,
    -1,
    "After these frames, which are black, the sequence goes on from this one: another view "
    "at once; -1: it does not");
DEFINE_uint64(seed, 0, "Of what is random");

namespace prism {
namespace {

constexpr double kDepthUnitsPerMetre = 5000;

// A frame of the disturbed sequence.
struct PlayedFrame {
  int source = 0;
  int64_t time_ns = 0;
  bool is_disturbed = false;
};

std::vector<PlayedFrame> PlayedFrames(const RgbdSequence& sequence) {
  const int end =
      FLAGS_count > 0 ? std::min(FLAGS_first + FLAGS_count, sequence.size()) : sequence.size();
  std::vector<PlayedFrame> frames;
  for (int i = 0; i < sequence.size(); ++i) {
    const bool is_disturbed = i >= FLAGS_first && i < end;
    if (is_disturbed && FLAGS_drop) continue;
    if (FLAGS_kidnap_to >= 0 && i == end) break;
    frames.push_back({i, sequence.time_ns(i), is_disturbed});
  }
  if (FLAGS_kidnap_to < 0 || end == sequence.size()) return frames;
  const int64_t later = sequence.time_ns(end) - sequence.time_ns(FLAGS_kidnap_to);
  for (int i = FLAGS_kidnap_to; i < sequence.size(); ++i) {
    frames.push_back({i, sequence.time_ns(i) + later, false});
  }
  return frames;
}

// The poses of the frames that show something, at the times they have now.
Trajectory PlayedGroundTruth(const Trajectory& groundtruth,
                             const RgbdSequence& sequence,
                             const std::vector<PlayedFrame>& frames) {
  Trajectory played;
  for (const PlayedFrame& frame : frames) {
    const int64_t time_ns = sequence.time_ns(frame.source);
    const auto nearest = std::min_element(
        groundtruth.begin(), groundtruth.end(), [&](const auto& left, const auto& right) {
          return std::abs(left.time_ns - time_ns) < std::abs(right.time_ns - time_ns);
        });
    if (nearest == groundtruth.end() || frame.is_disturbed) continue;
    played.push_back({frame.time_ns, nearest->world_from_cam});
  }
  return played;
}

ExitStatus Run() {
  namespace fs = std::filesystem;
  RequireFlag("sequence", FLAGS_sequence, "a folder in TUM RGB-D layout");
  RequireFlag("output_dir", FLAGS_output_dir, "a folder to write to");
  if (FLAGS_first < 0 || FLAGS_count < 0) {
    throw InputError("--first, --count",
                     std::to_string(FLAGS_first) + ", " + std::to_string(FLAGS_count),
                     "0 or more");
  }
  if (!(FLAGS_exposure > 0)) {
    throw InputError("--exposure", std::to_string(FLAGS_exposure), "above 0");
  }
  if (!(FLAGS_moving_patch_m >= 0 && FLAGS_moving_patch_m < 13)) {
    throw InputError("--moving_patch_m", std::to_string(FLAGS_moving_patch_m), "0 to 13 m");
  }
  if (!(FLAGS_gross_depths >= 0 && FLAGS_gross_depths <= 1)) {
    throw InputError("--gross_depths", std::to_string(FLAGS_gross_depths), "0 to 1");
  }
  const fs::path in(FLAGS_sequence), out(FLAGS_output_dir);
  if (fs::exists(out) && fs::equivalent(in, out)) {
    throw InputError("--output_dir", "the folder of the sequence", "another one");
  }
  const RgbdSequence sequence(FLAGS_sequence, PlenopticCamera(), RgbdConversionOptions());
  if (FLAGS_kidnap_to >= sequence.size()) {
    throw InputError("--kidnap_to",
                     std::to_string(FLAGS_kidnap_to),
                     "a frame of the sequence, below " + std::to_string(sequence.size()));
  }
  const bool is_black = FLAGS_black || FLAGS_kidnap_to >= 0;
  const std::vector<PlayedFrame> frames = PlayedFrames(sequence);
  for (const char* name : {"rgb", "depth"}) CreateDirectory((out / name).string());
  const int width = sequence.camera().raw_width, height = sequence.camera().raw_height;
  std::string associations;
  for (const auto& [i, time_ns, is_disturbed] : frames) {
    cv::Mat image = ReadGrayImage((in / sequence.image_path(i)).string(), width, height);
    cv::Mat depth = Read16BitImage((in / sequence.depth_path(i)).string(), width, height);
    if (is_disturbed) {
      std::mt19937_64 generator = SeededGenerator(FLAGS_seed, static_cast<uint64_t>(i));
      if (FLAGS_gross_depths > 0) SpoilDepth(FLAGS_gross_depths, &generator, &depth);
      if (FLAGS_moving_patch_m > 0) {
        MovingPatch patch;
        patch.depth = kDepthUnitsPerMetre * FLAGS_moving_patch_m;
        patch.seed = static_cast<unsigned>(FLAGS_seed);
        PasteMovingPatch(patch, i - FLAGS_first, &image, &depth);
      }
      if (is_black) CoverLens(&generator, &image, &depth);
      if (FLAGS_cover_half) CoverHalf(&generator, &image, &depth);
      ScaleExposure(FLAGS_exposure, &image);
    }
    const std::string time = FormatTime(time_ns);
    const std::string name = time + ".png";
    WriteImage((out / "rgb" / name).string(), image);
    WriteImage((out / "depth" / name).string(), depth);
    associations += time + " rgb/" + name + " " + time + " depth/" + name + "\n";
  }
  for (const char* name : {"calibration.txt", "groundtruth.txt"}) {
    if (fs::exists(in / name)) {
      fs::copy_file(in / name, out / name, fs::copy_options::overwrite_existing);
    }
  }
  if (FLAGS_kidnap_to >= 0 && fs::exists(in / "groundtruth.txt")) {
    WriteTrajectory(
        (out / "groundtruth.txt").string(),
        PlayedGroundTruth(ReadTrajectory((in / "groundtruth.txt").string()), sequence, frames));
  }
  WriteTextAtomically((out / "associations.txt").string(), associations);
  std::cout << "wrote " << frames.size() << " of " << sequence.size() << " frames to "
            << FLAGS_output_dir << "\n";
  return kExitDone;
}

}  // namespace
}  // namespace prism

int main(int argc, char** argv) {
  return prism::RunTool(
      {"prism_disturb",
       "copies an RGB-D sequence with disturbed frames, to see how the odometry takes them.",
       "--sequence=FOLDER --output_dir=FOLDER [--first=N --count=N] --drop | --exposure=GAIN | ...",
       "prism_disturb --sequence=DIR --output_dir=out/dark --first=60 --exposure=0.5"},
      argc,
      argv,
      prism::Run);
}
