// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/run/sequence.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

#include "prism/base/error.h"
#include "prism/base/format.h"
#include "prism/io/atomic_file.h"
#include "prism/io/camera_file.h"
#include "prism/io/focused_sequence.h"
#include "prism/io/frame_files.h"
#include "prism/io/raw_sequence.h"
#include "prism/io/rgbd_sequence.h"
#include "prism/io/video_file.h"
#include "prism/lightfield/chief_rays.h"
#include "prism/lightfield/light_field_processor.h"
#include "prism/run/folder_contents.h"
#include "prism/run/raw_input.h"

namespace prism {

// Written by the threads that read, while others wait for the next frame.
struct SharedVerdict {
  std::mutex mutex;
  LightFieldVerdict light_field;
};

namespace {

constexpr char kReadImage[] = "read image";
constexpr int kMaxPasses = 1000;

struct BadOption {
  std::string name, found, expected;
};

std::optional<BadOption> FindBadOption(const SequenceOptions& options) {
  const auto bad = [](const std::string& name, const auto& value, const std::string& expected) {
    return BadOption{name, std::to_string(value), expected};
  };
  const std::string& format = options.format;
  if (!format.empty() && format != "raw" && format != "focused" && format != "rgbd") {
    return BadOption{"format", "'" + format + "'", "raw, focused or rgbd"};
  }
  if (!IsRawColour(options.colour)) {
    return BadOption{"colour", "'" + options.colour + "'", kRawColours};
  }
  if (options.start_frame < 0) return bad("start_frame", options.start_frame, "0 or more");
  if (options.max_frames < 0) return bad("max_frames", options.max_frames, "0 (all) or more");
  if (options.ping_pong < 0 || options.ping_pong > kMaxPasses) {
    return bad("ping_pong", options.ping_pong, "0 to " + std::to_string(kMaxPasses) + " passes");
  }
  if (options.threads < 0 || options.threads > kMaxThreads) {
    return bad("threads", options.threads, "0 (one a core) to " + std::to_string(kMaxThreads));
  }
  FocusedImage focused_image;
  if (!ParseFocusedImage(options.focused_image, &focused_image)) {
    return BadOption{"focused_image", "'" + options.focused_image + "'", kFocusedImages};
  }
  if (!(options.rate_hz >= 0 && options.rate_hz < 1e6)) {
    return bad("rate_hz", options.rate_hz, "0 (by the names) or more");
  }
  if (!(options.depth_factor > 0 && options.depth_factor < 1e9)) {
    return bad("depth_factor", options.depth_factor, "more than 0, values a metre");
  }
  const double sigma = options.rgbd.inverse_depth_sigma;
  if (!(sigma >= 0 && sigma < 0.1)) return bad("rgbd_inverse_depth_sigma", sigma, "0 to 0.1");
  return std::nullopt;
}

std::string DetectFormat(const SequenceOptions& options) {
  if (!IsFolder(options.sequence) && !(IsVideoName(options.sequence) && IsFile(options.sequence))) {
    throw InputError(options.sequence, "no such folder", "a sequence folder or a video");
  }
  if (!options.format.empty()) return options.format;
  if (IsRawSequence(options.sequence)) return "raw";
  if (IsFocusedSequence(options.sequence)) return "focused";
  if (IsRgbdSequence(options.sequence)) return "rgbd";
  if (HasUnlistedFrames(options.sequence)) return "raw";
  throw InputError(
      options.sequence,
      "neither raw.txt, focused.txt, rgb.txt or associations.txt, nor images or a video",
      "a sequence in one of these layouts");
}

// What the layouts have in common.
struct Layout {
  PlenopticCamera camera;
  std::vector<std::string> report;
  std::string grid_report;
  std::vector<std::string> notes;
  std::vector<int64_t> times_ns;
  std::function<LightFieldFrame(int file_index, StageTimer* timer)> read;
  std::shared_ptr<SharedVerdict> verdict = std::make_shared<SharedVerdict>();
};

template <typename Reader>
std::vector<int64_t> TimesOf(const Reader& reader) {
  std::vector<int64_t> times_ns;
  for (int i = 0; i < reader.size(); ++i) times_ns.push_back(reader.time_ns(i));
  return times_ns;
}

Layout OpenRgbd(const SequenceOptions& options) {
  RgbdLayoutOptions layout_options;
  layout_options.depth_factor = options.depth_factor;
  if (!options.pinhole.empty()) layout_options.pinhole = ParsePinhole(options.pinhole);
  PlenopticCamera lens =
      options.camera.empty() ? StandInCamera() : ReadMetricCamera(options.camera);
  lens.focused_image = FocusedImage::kVirtualPoints;  // whatever raw frames are turned into
  auto reader = std::make_shared<const RgbdSequence>(
      options.sequence, lens, options.rgbd, layout_options, options.skip_missing);
  Layout layout;
  layout.report = {Format("frames: %d pairs of image and depth", reader->size()),
                   "pinhole: " + (options.pinhole.empty() ? "calibration.txt" : options.pinhole),
                   Format("depth: %g a metre", options.depth_factor)};
  layout.camera = reader->camera();
  layout.notes = reader->notes();
  layout.times_ns = TimesOf(*reader);
  layout.read = [reader](int index, StageTimer* timer) { return reader->Read(index, timer); };
  return layout;
}

Layout OpenFocused(const SequenceOptions& options) {
  const PlenopticCamera camera = ReadMetricCamera(options.camera);
  auto reader =
      std::make_shared<const FocusedSequence>(options.sequence, camera, options.skip_missing);
  Layout layout;
  layout.camera = camera;
  // What they show cannot be had back from images of chief rays.
  const bool is_to_be_turned = camera.focused_image == FocusedImage::kVirtualPoints &&
                               FocusedImageOf(options.focused_image) == FocusedImage::kChiefRays;
  if (is_to_be_turned) layout.camera.focused_image = FocusedImage::kChiefRays;
  layout.report = {Format("frames: %d of focused.txt", reader->size())};
  layout.times_ns = TimesOf(*reader);
  layout.read = [reader, camera, is_to_be_turned](int index, StageTimer* timer) {
    const StageTimer::Scope scope(timer, kReadImage);
    return is_to_be_turned ? ToChiefRays(camera, reader->Read(index)) : reader->Read(index);
  };
  return layout;
}

// Nothing but one brightness: too bright, or dark. Divided by the white image it would show that.
bool IsBlank(const cv::Mat& raw) {
  cv::Scalar mean, sigma;
  cv::meanStdDev(raw, mean, sigma);
  const double full_scale = raw.depth() == CV_8U ? 255 : 65535;
  return *std::max_element(sigma.val, sigma.val + raw.channels()) < 0.001 * full_scale;
}

LightFieldFrame BlankFrame(const PlenopticCamera& camera, int64_t time_ns) {
  const int width = camera.focused_width(), height = camera.focused_height();
  LightFieldFrame frame;
  frame.time_ns = time_ns;
  frame.image = BuildPyramid(ImageF(width, height, 0), LightFieldOptions().pyramid_levels);
  frame.inverse_virtual_depth = frame.sigma = ImageF(width, height, 0);
  frame.depth_correlation_px = kMicroImageDepthCorrelation;
  return frame;
}

Layout OpenRaw(const SequenceOptions& options) {
  RawInput input = OpenRawInput({options.sequence,
                                 options.camera,
                                 options.micro_lens_grid,
                                 options.white_image,
                                 options.colour,
                                 options.threads,
                                 options.focus_colour,
                                 options.rate_hz,
                                 options.skip_missing,
                                 FocusedImageOf(options.focused_image)});
  RequireMetricDepth(input.camera, options.camera);
  auto reader = std::make_shared<const RawSequence>(std::move(*input.sequence));
  auto processor = std::make_shared<LightFieldProcessor>(input.camera, input.white, input.options);
  Layout layout;
  layout.camera = input.camera;
  layout.grid_report = input.grid_report;
  layout.report = {"frames: " + reader->source()};
  if (!input.grid_report.empty()) layout.report.push_back(input.grid_report);
  layout.times_ns = TimesOf(*reader);
  layout.read =
      [reader, processor, verdict = layout.verdict, totals = std::map<std::string, double>()](
          int index, StageTimer* timer) mutable {
        RawFrame raw;
        {
          const StageTimer::Scope scope(timer, kReadImage);
          raw = reader->Read(index);
        }
        if (IsBlank(raw.image)) return BlankFrame(processor->camera(), raw.time_ns);
        LightFieldFrame frame = processor->Process(raw);
        for (const auto& [stage, ms] : TakeNewTimes(processor->timer(), &totals))
          timer->Add(stage, ms);
        const std::lock_guard<std::mutex> lock(verdict->mutex);
        verdict->light_field.Add(frame.sigma, processor->noise(), processor->misfit());
        return frame;
      };
  return layout;
}

Layout OpenLayout(const std::string& format, const SequenceOptions& options) {
  if (format == "rgbd") return OpenRgbd(options);
  if (format == "focused") return OpenFocused(options);
  return OpenRaw(options);
}

PlayOrder OrderFrames(const std::vector<int64_t>& times_ns, const SequenceOptions& options) {
  const int count = static_cast<int>(times_ns.size());
  if (options.start_frame >= count) {
    throw OptionError(
        "start_frame",
        std::to_string(options.start_frame),
        "0 to " + std::to_string(count - 1) + ", the last frame of " + options.sequence);
  }
  const int available = count - options.start_frame;
  const int length = options.max_frames > 0 ? std::min(options.max_frames, available) : available;
  const auto first = times_ns.begin() + options.start_frame;
  return PlayOrder({first, first + length}, {options.reverse, std::max(options.ping_pong, 1)});
}

}  // namespace

bool SequenceOptions::IsValid(std::string* error) const {
  const std::optional<BadOption> bad = FindBadOption(*this);
  if (bad) *error = bad->name + " of " + bad->found + ", expected " + bad->expected;
  return !bad;
}

Sequence::Sequence(const SequenceOptions& options) {
  if (const std::optional<BadOption> bad = FindBadOption(options)) {
    throw OptionError(bad->name, bad->found, bad->expected);
  }
  format_ = DetectFormat(options);
  const SequenceOptions complete = CompleteFromFolder(options, format_, &input_report_);
  camera_path_ = complete.camera;
  Layout layout = OpenLayout(format_, complete);
  for (std::string& line : layout.report) input_report_.push_back(std::move(line));
  camera_ = layout.camera;
  grid_report_ = std::move(layout.grid_report);
  notes_ = std::move(layout.notes);
  play_order_ = OrderFrames(layout.times_ns, options);
  start_frame_ = options.start_frame;
  read_ = std::move(layout.read);
  verdict_ = std::move(layout.verdict);
}

LightFieldVerdict Sequence::Verdict() const {
  const std::lock_guard<std::mutex> lock(verdict_->mutex);
  return verdict_->light_field;
}

// As many as even out what frames take, of large ones fewer: one being made while another is
// tracked is what matters.
size_t Sequence::FramesAhead() const {
  constexpr size_t kMost = 3;
  constexpr size_t kManyBytes = size_t{64} << 20;
  constexpr size_t kBytesAPixel = 14;  // image with its pyramid, inverse virtual depth, sigma
  const size_t bytes =
      kBytesAPixel * static_cast<size_t>(camera_.focused_width()) * camera_.focused_height();
  return std::clamp(kManyBytes / std::max(bytes, size_t{1}), size_t{1}, kMost);
}

void Sequence::ReadAhead() {
  while (pending_.size() < FramesAhead() && next_to_read_ < size()) {
    const int index = start_frame_ + play_order_->file_index(next_to_read_++);
    pending_.push_back(std::async(std::launch::async, [this, index] { return Read(index); }));
  }
}

Sequence::FrameRead Sequence::Read(int file_index) {
  const std::lock_guard<std::mutex> lock(read_mutex_);
  StageTimer timer;  // of its own: the caller may be looking at that of the frames before
  FrameRead read;
  read.frame = read_(file_index, &timer);
  read.stage_ms = timer.Totals();
  return read;
}

std::optional<LightFieldFrame> Sequence::Next() {
  ReadAhead();
  if (pending_.empty()) return std::nullopt;
  std::future<FrameRead> future = std::move(pending_.front());
  pending_.pop_front();
  const int n = next_to_return_++;
  FrameRead read;
  try {
    read = future.get();
  } catch (const InputError& error) {
    throw UnreadableFrame(error, play_order_->time_ns(n));
  }
  for (const auto& [stage, ms] : read.stage_ms) timer_.Add(stage, ms);
  read.frame.time_ns = play_order_->time_ns(n);
  ReadAhead();
  return std::move(read.frame);
}

}  // namespace prism
