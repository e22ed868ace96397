// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "prism/base/error.h"
#include "prism/base/stage_timer.h"
#include "prism/camera/plenoptic_camera.h"
#include "prism/io/rgbd_to_plenoptic.h"
#include "prism/lightfield/verdict.h"
#include "prism/run/play_order.h"
#include "prism/scene/frame.h"

namespace prism {

// What a user says of a sequence. Only `sequence` has to be said where its folder holds the rest
// (CompleteFromFolder).
struct SequenceOptions {
  std::string sequence;  // folder
  // File; for RGB-D input the plenoptic camera to stand in for; empty: that of the folder.
  std::string camera;
  std::string format;  // "raw", "focused" or "rgbd"; empty: by what the folder holds

  // Of raw and focused frames: what they are turned into, chief_rays or virtual_points
  // (FocusedImage). Focused frames that show chief rays stay as they are.
  std::string focused_image = "chief_rays";

  // Of raw frames.
  std::string micro_lens_grid;  // file; empty: the camera file's own grid
  std::string white_image;      // file; empty: the folder's white.png, else none
  std::string colour = "auto";  // auto, gray, colour, bayer_rggb, _bggr, _grbg or _gbrg
  int threads = 0;              // that process a frame; 0: one a core
  bool focus_colour = false;    // LightFieldFrame::colour as well, at the price of three images
  double rate_hz = 0;           // of frames without a list; 0: times in their names, else 10

  RgbdConversionOptions rgbd;  // of RGB-D frames
  std::string pinhole;         // see ParsePinhole; empty: calibration.txt
  double depth_factor = 5000;  // values of depth images a metre

  int start_frame = 0;   // first frame of the file that is played
  int max_frames = 0;    // frames played in a pass; 0: all
  bool reverse = false;  // the first pass is played backwards
  int ping_pong = 0;     // number of passes, forwards and backwards in turn; 0: one

  // Files that are missing are frames that cannot be read, instead of an error before the start.
  bool skip_missing = false;

  // As far as it can be told without a look at the files.
  bool IsValid(std::string* error) const;
};

// A frame whose files cannot be read; what() says why.
class UnreadableFrame : public InputError {
 public:
  UnreadableFrame(const InputError& reason, int64_t played_time_ns)
      : InputError(reason), time_ns(played_time_ns) {}

  int64_t time_ns;
};

struct SharedVerdict;

// A sequence in one of the layouts that sequences/README.md describes, from which frames come in
// the order they are played, ready for Odometry::Process:
//
//   Sequence sequence(options);
//   Odometry odometry(sequence.camera(), OdometryOptions());
//   while (std::optional<LightFieldFrame> frame = sequence.Next()) {
//     odometry.Process(std::move(*frame));
//   }
//
// Raw frames are turned into depth and focused image on the way; their micro-lens grid is refined
// on the white image, or on some frames where there is none (raw_input.h).
class Sequence {
 public:
  // Throws OptionError for a value that does not fit, also one IsValid cannot tell, and InputError
  // for a file that does not.
  explicit Sequence(const SequenceOptions& options);
  Sequence(const Sequence&) = delete;
  Sequence& operator=(const Sequence&) = delete;

  const std::string& format() const { return format_; }            // raw, focused or rgbd
  const PlenopticCamera& camera() const { return camera_; }        // raw: with the refined grid
  const std::string& camera_path() const { return camera_path_; }  // given or found; empty: none
  const PlayOrder& play_order() const { return *play_order_; }
  // What was found in the folder and what was assumed, a line each; the grid's report is one.
  const std::vector<std::string>& input_report() const { return input_report_; }
  // What the refinement of the grid of a raw sequence found, one line; else empty.
  const std::string& grid_report() const { return grid_report_; }
  // What is worth knowing of the files, a line each: images that are left out.
  const std::vector<std::string>& notes() const { return notes_; }
  // What can be said of the light field of a raw sequence, from all frames read so far
  // (LightFieldVerdict); empty of other layouts.
  LightFieldVerdict Verdict() const;

  // Frames that are played, those already returned among them.
  int size() const { return play_order_->size(); }

  // The next frame with its time as played; nothing at the end. From the first call on, the frames
  // behind it are read in threads of their own while the caller works on this one. Throws
  // UnreadableFrame if it cannot be read; the call after that goes on with the one behind it.
  std::optional<LightFieldFrame> Next();

  // Times of reading and processing the frames that Next has returned, a duration a frame of each
  // stage: "read image", of RGB-D frames "convert frame", of raw ones those of LightFieldProcessor.
  const StageTimer& timer() const { return timer_; }

 private:
  struct FrameRead {
    LightFieldFrame frame;
    std::map<std::string, double> stage_ms;
  };

  void ReadAhead();
  size_t FramesAhead() const;
  FrameRead Read(int file_index);

  std::string format_;
  std::string camera_path_;
  PlenopticCamera camera_;
  std::vector<std::string> input_report_;
  std::string grid_report_;
  std::vector<std::string> notes_;
  std::optional<PlayOrder> play_order_;
  int start_frame_ = 0;
  std::function<LightFieldFrame(int file_index, StageTimer* timer)> read_;
  std::shared_ptr<SharedVerdict> verdict_;  // of the frames that `read_` has read

  std::mutex read_mutex_;  // one frame at a time: raw frames share a processor
  int next_to_read_ = 0;
  int next_to_return_ = 0;
  StageTimer timer_;
  // Destroyed first, which waits for the threads.
  std::deque<std::future<FrameRead>> pending_;
};

}  // namespace prism
