// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <functional>
#include <future>
#include <mutex>
#include <string>
#include <vector>

#include "prism/camera/plenoptic_camera.h"
#include "prism/io/rgbd_to_plenoptic.h"
#include "prism/scene/frame.h"
#include "prism/scene/trajectory.h"

namespace prism {

struct SequenceOptions {
  std::string sequence;         // folder
  std::string camera;           // file
  std::string micro_lens_grid;  // file, optional
  std::string white_image;      // file, optional
  std::string colour = "auto";  // of raw frames (RawInputOptions)
  std::string format;           // "raw", "focused", "rgbd" or empty: by what the folder holds
  int start_frame = 0;
  int max_frames = 0;    // 0: all
  bool reverse = false;  // the first pass is played backwards
  int ping_pong = 0;     // number of passes, forwards and backwards in turn; 0: one
  RgbdConversionOptions rgbd;
};

// A sequence opened in one of its formats: frames by number, in the order they are played. Times go
// on rising however they are played: each pass takes as long as the sequence, and begins where the
// one before ends.
struct FrameSource {
  std::string format;
  PlenopticCamera camera;
  std::vector<int> order;         // file index of each frame to play
  std::vector<int64_t> times_ns;  // as played
  std::function<LightFieldFrame(int file_index)> read;
  // How they are played; `first_ns` and `last_ns` are the times of the file's frames.
  int passes = 1;
  bool reverse = false;
  int64_t first_ns = 0;
  int64_t last_ns = 0;

  int size() const { return static_cast<int>(order.size()); }
  bool IsPlayedAsFiled() const { return passes == 1 && !reverse; }
  // The time at which a time of the file is played in a pass, and the other way about.
  int64_t PlayTime(int pass, int64_t file_time_ns) const;
  int64_t FileTime(int64_t play_time_ns) const;
};

// A trajectory in the file's times (the ground truth) as the frames are played: mirrored where they
// are played backwards.
Trajectory AsPlayed(const FrameSource& source, const Trajectory& in_file_times);

// The other way about, for a single pass.
Trajectory InFileTimes(const FrameSource& source, const Trajectory& as_played);

// Throws InputError.
FrameSource OpenSequence(const SequenceOptions& options);

// Reads frames ahead in threads of their own, one at a time, so that decoding goes on while a
// keyframe is optimised.
class Prefetcher {
 public:
  explicit Prefetcher(const FrameSource& source);
  // The next frame in order. Precondition: called at most size() times. Throws InputError.
  LightFieldFrame Next();

 private:
  static constexpr size_t kAhead = 3;  // frames

  void Fill();

  const FrameSource& source_;
  int next_to_start_ = 0;
  int next_to_return_ = 0;
  std::mutex read_mutex_;  // the source reads one frame at a time
  std::deque<std::future<LightFieldFrame>> pending_;
};

}  // namespace prism
