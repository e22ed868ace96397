// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/video_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

#include "prism/base/error.h"

namespace prism {
namespace {

constexpr int kKept = 4;  // frames
// Others that OpenCV would try have more to say and to leave behind than the error.
constexpr int kDecoder = cv::CAP_FFMPEG;

}  // namespace

bool IsVideoName(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const auto& known = {".avi", ".mkv", ".mov", ".mp4"};
  return std::find(known.begin(), known.end(), extension) != known.end();
}

VideoFile::VideoFile(const std::string& path) : path_(path), capture_(path, kDecoder) {
  if (!capture_.isOpened()) {
    throw InputError(path,
                     "a file that FFmpeg does not open as a video",
                     "a video that this machine has a decoder for, or its frames as images");
  }
  const double count = capture_.get(cv::CAP_PROP_FRAME_COUNT);
  if (!(count >= 1 && count < 1e8)) {
    throw InputError(path, "no number of frames in it", "a video that tells it");
  }
  size_ = static_cast<int>(std::lround(count));
  const double rate_hz = capture_.get(cv::CAP_PROP_FPS);
  if (rate_hz > 0 && rate_hz < 1e6) rate_hz_ = rate_hz;
}

cv::Mat VideoFile::Read(int index) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto known = recent_.find(index);
  if (known != recent_.end()) return known->second;
  // Decoding what lies before is exact, which seeking is not in every file.
  if (index < next_) {
    if (!capture_.open(path_, kDecoder)) {
      throw InputError(path_, "a video that opens no more", "a video");
    }
    next_ = 0;
    recent_.clear();
  }
  cv::Mat image;
  for (; next_ <= index; ++next_) {
    const bool is_there = index - next_ < kKept ? capture_.read(image) : capture_.grab();
    if (!is_there) {
      throw InputError(path_ + ", frame " + std::to_string(next_),
                       "the end of what can be decoded",
                       std::to_string(size_) + " frames, as the video says");
    }
    if (index - next_ < kKept) recent_[next_] = image.clone();  // the next overwrites it
  }
  while (static_cast<int>(recent_.size()) > kKept) recent_.erase(recent_.begin());
  return recent_.at(index);
}

}  // namespace prism
