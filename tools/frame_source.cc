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
  RawInput input = OpenRawInput({options.sequence,
                                 options.camera,
                                 options.micro_lens_grid,
                                 options.white_image,
                                 options.colour});
  FrameSource source;
  source.camera = input.camera;
  auto sequence = std::make_shared<const RawSequence>(std::move(*input.sequence));
  auto processor = std::make_shared<LightFieldProcessor>(input.camera, input.white, input.options);
  for (int i = 0; i < sequence->size(); ++i) source.times_ns.push_back(sequence->time_ns(i));
  source.read = [sequence, processor](int index) {
    return processor->Process(sequence->Read(index));
  };
  return source;
}

// Chooses and orders the frames.
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
  source->passes = std::max(options.ping_pong, 1);
  source->reverse = options.reverse;
  source->first_ns = file_times[options.start_frame];
  source->last_ns = file_times[options.start_frame + length - 1];
  for (int pass = 0; pass < source->passes; ++pass) {
    const bool is_backwards = (pass % 2 == 1) != options.reverse;
    for (int i = 0; i < length; ++i) {
      if (pass > 0 && i == 0) continue;  // the turning frame is played once
      const int index = options.start_frame + (is_backwards ? length - 1 - i : i);
      source->order.push_back(index);
      source->times_ns.push_back(source->PlayTime(pass, file_times[index]));
    }
  }
}

}  // namespace

int64_t FrameSource::PlayTime(int pass, int64_t file_time_ns) const {
  const bool is_backwards = (pass % 2 == 1) != reverse;
  return first_ns + pass * (last_ns - first_ns) +
         (is_backwards ? last_ns - file_time_ns : file_time_ns - first_ns);
}

int64_t FrameSource::FileTime(int64_t play_time_ns) const {
  const int64_t duration_ns = last_ns - first_ns;
  const int64_t since_start_ns = play_time_ns - first_ns;
  const int64_t pass =
      duration_ns > 0 ? std::clamp<int64_t>(since_start_ns / duration_ns, 0, passes - 1) : 0;
  const bool is_backwards = (pass % 2 == 1) != reverse;
  const int64_t in_pass_ns = since_start_ns - pass * duration_ns;
  return is_backwards ? last_ns - in_pass_ns : first_ns + in_pass_ns;
}

Trajectory AsPlayed(const FrameSource& source, const Trajectory& in_file_times) {
  if (source.IsPlayedAsFiled()) return in_file_times;
  Trajectory played;
  for (int pass = 0; pass < source.passes; ++pass) {
    const size_t begin = played.size();
    for (const StampedPose& pose : in_file_times) {
      // Only the two ends of the whole have poses beyond the frames: elsewhere the play turns.
      const int64_t time_ns = source.PlayTime(pass, pose.time_ns);
      const int64_t turn_before_ns = source.first_ns + pass * (source.last_ns - source.first_ns);
      const int64_t turn_after_ns = turn_before_ns + (source.last_ns - source.first_ns);
      if (pass > 0 && time_ns <= turn_before_ns) continue;
      if (pass + 1 < source.passes && time_ns > turn_after_ns) continue;
      played.push_back({time_ns, pose.world_from_cam});
    }
    if ((pass % 2 == 1) != source.reverse) {
      std::reverse(played.begin() + static_cast<std::ptrdiff_t>(begin), played.end());
    }
  }
  return played;
}

Trajectory InFileTimes(const FrameSource& source, const Trajectory& as_played) {
  CHECK_EQ(source.passes, 1);
  Trajectory in_file_times = as_played;
  for (StampedPose& pose : in_file_times) pose.time_ns = source.FileTime(pose.time_ns);
  if (source.reverse) std::reverse(in_file_times.begin(), in_file_times.end());
  return in_file_times;
}

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
