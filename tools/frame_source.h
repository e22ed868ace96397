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

namespace prism {

struct SequenceOptions {
  std::string sequence;         // folder
  std::string camera;           // file
  std::string micro_lens_grid;  // file, optional
  std::string white_image;      // file, optional
  std::string format;           // "raw", "focused", "rgbd" or empty: by what the folder holds
  int start_frame = 0;
  int max_frames = 0;  // 0: all
  int ping_pong = 0;   // number of passes, forwards and backwards in turn; 0: one, forwards
  RgbdConversionOptions rgbd;
};

// A sequence opened in one of its formats: frames by number, in the order they are played.
struct FrameSource {
  std::string format;
  PlenopticCamera camera;
  std::vector<int> order;  // file index of each frame to play
  std::vector<int64_t> times_ns;
  std::function<LightFieldFrame(int file_index)> read;

  int size() const { return static_cast<int>(order.size()); }
};

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
