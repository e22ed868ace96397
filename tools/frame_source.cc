// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/frame_source.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>

#include <glog/logging.h>

#include "prism/base/error.h"
#include "prism/io/camera_file.h"
#include "prism/io/focused_sequence.h"
#include "prism/io/raw_sequence.h"
#include "prism/io/rgbd_sequence.h"
#include "prism/lightfield/light_field_processor.h"
#include "tools/raw_input.h"

namespace prism {
namespace {

std::string DetectFormat(const SequenceOptions& options) {
  if (!std::filesystem::is_directory(options.sequence)) {
    throw InputError(options.sequence, "no such folder", "a sequence folder");
  }
  if (!options.format.empty()) return options.format;
  if (IsRawSequence(options.sequence)) return "raw";
  if (IsFocusedSequence(options.sequence)) return "focused";
  if (IsRgbdSequence(options.sequence)) return "rgbd";
  throw InputError(options.sequence,
                   "neither raw.txt, focused.txt nor rgb.txt or associations.txt",
                   "a sequence in one of these layouts");
}

FrameSource OpenRgbd(const SequenceOptions& options) {
  auto sequence = std::make_shared<const RgbdSequence>(
      options.sequence, ReadPlenopticCamera(options.camera), options.rgbd);
  FrameSource source;
  source.camera = sequence->camera();
  for (int i = 0; i < sequence->size(); ++i) source.times_ns.push_back(sequence->time_ns(i));
  source.read = [sequence](int index) { return sequence->Read(index); };
  return source;
}

FrameSource OpenFocused(const SequenceOptions& options) {
  FrameSource source;
  source.camera = ReadPlenopticCamera(options.camera);
  auto sequence = std::make_shared<const FocusedSequence>(options.sequence, source.camera);
  for (int i = 0; i < sequence->size(); ++i) source.times_ns.push_back(sequence->time_ns(i));
  source.read = [sequence](int index) { return sequence->Read(index); };
  return source;
}

// Frames are processed as they are read, one at a time.
FrameSource OpenRaw(const SequenceOptions& options) {
  RawInput input =
      OpenRawInput(options.sequence, options.camera, options.micro_lens_grid, options.white_image);
  FrameSource source;
  source.camera = input.camera;
  auto sequence = std::make_shared<const RawSequence>(std::move(*input.sequence));
  auto processor =
      std::make_shared<LightFieldProcessor>(input.camera, input.white, LightFieldOptions{});
  for (int i = 0; i < sequence->size(); ++i) source.times_ns.push_back(sequence->time_ns(i));
  source.read = [sequence, processor](int index) {
    return processor->Process(sequence->Read(index));
  };
  return source;
}

// Chooses and orders the frames; when played back and forth, times go on rising.
void OrderFrames(const SequenceOptions& options, FrameSource* source) {
  const int count = static_cast<int>(source->times_ns.size());
  if (options.start_frame < 0 || options.start_frame >= count) {
    throw InputError(
        "--start_frame",
        std::to_string(options.start_frame),
        "0 to " + std::to_string(count - 1) + ", the last frame of " + options.sequence);
  }
  const int available = count - options.start_frame;
  const int length = options.max_frames > 0 ? std::min(options.max_frames, available) : available;
  const std::vector<int64_t> file_times = std::move(source->times_ns);
  source->times_ns.clear();
  const int passes = std::max(options.ping_pong, 1);
  const int64_t first = file_times[options.start_frame];
  const int64_t duration = file_times[options.start_frame + length - 1] - first;
  for (int pass = 0; pass < passes; ++pass) {
    for (int i = 0; i < length; ++i) {
      if (pass > 0 && i == 0) continue;  // the turning frame is played once
      const int index = options.start_frame + (pass % 2 == 0 ? i : length - 1 - i);
      const int64_t since_start = file_times[index] - first;
      source->order.push_back(index);
      source->times_ns.push_back(first + pass * duration +
                                 (pass % 2 == 0 ? since_start : duration - since_start));
    }
  }
}

}  // namespace

FrameSource OpenSequence(const SequenceOptions& options) {
  const std::string format = DetectFormat(options);
  FrameSource source;
  if (format == "rgbd") {
    source = OpenRgbd(options);
  } else if (format == "focused") {
    source = OpenFocused(options);
  } else if (format == "raw") {
    source = OpenRaw(options);
  } else {
    throw InputError("--format", "'" + format + "'", "raw, focused or rgbd");
  }
  source.format = format;
  OrderFrames(options, &source);
  return source;
}

Prefetcher::Prefetcher(const FrameSource& source) : source_(source) { Fill(); }

void Prefetcher::Fill() {
  while (pending_.size() < kAhead && next_to_start_ < source_.size()) {
    pending_.push_back(
        std::async(std::launch::async, [this, index = source_.order[next_to_start_]] {
          const std::lock_guard<std::mutex> lock(read_mutex_);
          return source_.read(index);
        }));
    ++next_to_start_;
  }
}

LightFieldFrame Prefetcher::Next() {
  CHECK(!pending_.empty());
  LightFieldFrame frame = pending_.front().get();
  pending_.pop_front();
  frame.time_ns = source_.times_ns[next_to_return_];
  ++next_to_return_;
  Fill();
  return frame;
}

}  // namespace prism
