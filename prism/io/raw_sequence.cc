// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/raw_sequence.h"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <utility>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"
#include "prism/io/image_file.h"

namespace prism {
namespace {

// Of frames in a row that cannot be read, to find one that can.
constexpr int kMaxTries = 20;

void RequireRawType(const std::string& path, const cv::Mat& image) {
  const bool depth = image.depth() == CV_8U || image.depth() == CV_16U;
  if (!depth || (image.channels() != 1 && image.channels() != 3)) {
    throw InputError(path,
                     std::to_string(image.channels()) + " channel(s) of " +
                         std::to_string(8 * image.elemSize1()) + " bits",
                     "1 or 3 channels of 8 or 16 bits");
  }
}

}  // namespace

RawSequence::RawSequence(const std::string& folder,
                         const PlenopticCamera& camera,
                         int channels,
                         double rate_hz,
                         bool skip_missing)
    : folder_(folder), width_(camera.raw_width), height_(camera.raw_height), channels_(channels) {
  FrameFiles files = FindFrameFiles(folder, rate_hz, skip_missing);
  files_ = std::move(files.frames);
  source_ = std::move(files.source);
  if (files_.front().video_frame >= 0) video_ = std::make_shared<VideoFile>(files_.front().path);
}

std::vector<RawFrame> RawSequence::ReadSome(int max_frames) const {
  const int count = std::min(size(), max_frames);
  std::vector<RawFrame> frames;
  std::exception_ptr first_error;
  for (int i = 0; i < count; ++i) {
    // Of a stretch of the sequence the first frame that can be read.
    for (int k = i * size() / count; k < (i + 1) * size() / count; ++k) {
      try {
        frames.push_back(Read(k));
        break;
      } catch (const InputError&) {
        if (!first_error) first_error = std::current_exception();
      }
      if (k - i * size() / count >= kMaxTries) break;
    }
  }
  if (frames.empty()) std::rethrow_exception(first_error);
  return frames;
}

std::vector<cv::Mat> ImagesOf(const std::vector<RawFrame>& frames) {
  std::vector<cv::Mat> images;
  for (const RawFrame& frame : frames) images.push_back(frame.image);
  return images;
}

RawFrame RawSequence::Read(int index) const {
  const FrameFile& entry = files_[index];
  RawFrame frame;
  frame.time_ns = entry.time_ns;
  frame.path = entry.path;
  frame.image = video_ ? video_->Read(entry.video_frame) : ReadImageUnchanged(entry.path);
  RequireImageSize(entry.path, frame.image, width_, height_);
  RequireRawType(entry.path, frame.image);
  if (type_ >= 0 && frame.image.depth() != CV_MAT_DEPTH(type_)) {
    throw InputError(entry.path,
                     std::to_string(8 * frame.image.elemSize1()) + " bits a channel",
                     std::to_string(8 * CV_ELEM_SIZE1(type_)) + ", as the frames before");
  }
  if (channels_ != 0 && frame.image.channels() != channels_) {
    throw InputError(
        entry.path,
        channels_ == 1 ? "a colour image" : "an image of one channel",
        channels_ == 1 ? "one channel, gray or Bayer as declared" : "a colour image, as declared");
  }
  return frame;
}

std::string RawSequence::WhiteImagePath() const {
  for (const char* name : {"white.png", "white.tif", "white.tiff", "white.bmp", "white.jpg"}) {
    std::string path = FindFile(folder_, name);
    if (!path.empty()) return path;
  }
  return "";
}

cv::Mat ReadWhiteImage(const std::string& path, const PlenopticCamera& camera) {
  cv::Mat white = ReadImageUnchanged(path);
  RequireImageSize(path, white, camera.raw_width, camera.raw_height);
  RequireRawType(path, white);
  cv::Mat values;
  white.reshape(1, 1).convertTo(values, CV_32F, white.depth() == CV_8U ? 1.0 : 1.0 / 257);
  float* begin = values.ptr<float>();
  float* nth = begin + static_cast<std::ptrdiff_t>(0.99 * values.cols);
  std::nth_element(begin, nth, begin + values.cols);
  if (*nth < 0.02f * 255) {
    throw InputError(path,
                     "a black image (99 % of it below " + std::to_string(*nth) + " of 255)",
                     "a white image");
  }
  return white;
}

bool IsRawSequence(const std::string& folder) { return IsFile(InFolder(folder, "raw.txt")); }

}  // namespace prism
