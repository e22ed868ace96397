// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <mutex>
#include <string>

#include <opencv2/core/mat.hpp>
#include <opencv2/videoio.hpp>

namespace prism {

// True for the names of videos (avi, mkv, mov, mp4), whatever their case.
bool IsVideoName(const std::string& path);

// Frames of a video as OpenCV decodes them, 8 bits and 3 channels (BGR). Throws InputError naming
// the file if it does not open (no video, or no decoder for it), does not say how many frames it
// has, or ends before.
class VideoFile {
 public:
  explicit VideoFile(const std::string& path);

  int size() const { return size_; }
  double rate_hz() const { return rate_hz_; }  // 0: the file does not say

  // Safe to call from several threads. Quick where frames are asked for as they follow each other,
  // give or take a few; the way back begins at the start again. Precondition: 0 <= index < size().
  cv::Mat Read(int index);

 private:
  std::string path_;
  std::mutex mutex_;  // guards what follows
  cv::VideoCapture capture_;
  int next_ = 0;                   // frame that is decoded next
  std::map<int, cv::Mat> recent_;  // the last that were decoded: threads read ahead of each other
  int size_ = 0;
  double rate_hz_ = 0;
};

}  // namespace prism
