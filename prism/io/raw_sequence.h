// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "prism/camera/plenoptic_camera.h"
#include "prism/io/frame_files.h"
#include "prism/io/video_file.h"
#include "prism/scene/frame.h"

namespace prism {

// A folder of raw plenoptic frames: those that FindFrameFiles finds (`raw.txt`, or what lies
// there), images of 8 or 16 bits, gray, Bayer or colour, and optionally `white.png` (.tif, .bmp,
// .jpg).
//
// Throws InputError: no such folder or frames, an empty list, times that do not increase, a file
// that is missing (with `skip_missing` only when it is read); on Read an image that does not
// decode, is of another size than the camera's raw image, has another number of channels than
// declared (a colour image where gray or a Bayer pattern is) or other bits than the frames before.
class RawSequence {
 public:
  // `channels`: 1 (gray or Bayer) or 3 (colour) of every image; 0: either. `rate_hz`: of frames
  // without a list; 0: as FindFrameFiles says.
  RawSequence(const std::string& folder,
              const PlenopticCamera& camera,
              int channels = 0,
              double rate_hz = 0,
              bool skip_missing = false);

  int size() const { return static_cast<int>(files_.size()); }
  int64_t time_ns(int index) const { return files_[index].time_ns; }
  const std::string& path(int index) const { return files_[index].path; }
  // Where the frames and their times are from, for people to read.
  const std::string& source() const { return source_; }

  // Safe to call from several threads. Precondition: 0 <= index < size().
  RawFrame Read(int index) const;

  // At most `max_frames`, spread evenly over the sequence. Frames that cannot be read are passed
  // over; the error of the first is thrown only if there are no others.
  std::vector<RawFrame> ReadSome(int max_frames) const;

  // The OpenCV type of a frame that was read: its bits are those of all others.
  void set_type(int type) { type_ = type; }

  // Path of the folder's white image, empty if it has none.
  std::string WhiteImagePath() const;

 private:
  std::string folder_;
  int width_, height_;
  int channels_;
  int type_ = -1;  // not known
  std::vector<FrameFile> files_;
  std::shared_ptr<VideoFile> video_;  // that holds all of them; null: they are images
  std::string source_;
};

std::vector<cv::Mat> ImagesOf(const std::vector<RawFrame>& frames);

// A white image for the camera. Throws InputError if it is missing, does not decode, has another
// size, or is black (its 99th percentile below 2 % of full scale).
cv::Mat ReadWhiteImage(const std::string& path, const PlenopticCamera& camera);

// True if the folder has a raw.txt.
bool IsRawSequence(const std::string& folder);

}  // namespace prism
