// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/focused_sequence.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"
#include "prism/io/image_file.h"
#include "prism/io/time_list.h"

namespace prism {
namespace {

constexpr int kPyramidLevels = 5;
constexpr double kMaxSigma = 0.1;  // at value 65535

cv::Mat Encode(const ImageF& image, const ImageF& measured, double offset, double scale) {
  cv::Mat encoded(image.height(), image.width(), CV_16UC1);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double value = std::round(65535 * (offset + scale * image(x, y)));
      encoded.at<uint16_t>(y, x) =
          measured(x, y) > 0 ? static_cast<uint16_t>(std::clamp(value, 1.0, 65535.0)) : 0;
    }
  }
  return encoded;
}

}  // namespace

FocusedSequence::FocusedSequence(const std::string& folder,
                                 const PlenopticCamera& camera,
                                 bool skip_missing,
                                 double default_sigma)
    : width_(camera.focused_width()),
      height_(camera.focused_height()),
      default_sigma_(default_sigma) {
  const std::filesystem::path root(folder);
  const std::string list = (root / "focused.txt").string();
  for (const TimedLine& line : ReadTimeList(list, 2, 3)) {
    for (const std::string& word : line.words) {
      if (skip_missing || IsFile(InFolder(folder, word))) continue;
      throw InputError(list + ":" + std::to_string(line.line_number),
                       "'" + word + "', which does not exist",
                       "an image");
    }
    entries_.push_back({line.time_ns,
                        (root / line.words[0]).string(),
                        (root / line.words[1]).string(),
                        line.words.size() > 2 ? (root / line.words[2]).string() : ""});
  }
  if (entries_.empty()) {
    throw InputError(
        list, "no frames", "a line `time image inverse_virtual_depth [sigma]` a frame");
  }
}

ImageF ReadInverseVirtualDepth(const std::string& path, int width, int height) {
  const cv::Mat encoded = Read16BitImage(path, width, height);
  ImageF depth(width, height, 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int value = encoded.at<uint16_t>(y, x);
      if (value == 0) continue;
      const float w = static_cast<float>(1 - value / 65535.0);
      if (!(w > 0 && w <= 0.5f)) {
        throw InputError(path,
                         "1/v of " + std::to_string(w) + " at pixel (" + std::to_string(x) + ", " +
                             std::to_string(y) + ")",
                         "0 < 1/v <= 0.5");
      }
      depth(x, y) = w;
    }
  }
  return depth;
}

LightFieldFrame FocusedSequence::Read(int index) const {
  const Entry& entry = entries_[index];
  LightFieldFrame frame;
  frame.time_ns = entry.time_ns;
  frame.depth_correlation_px = kMicroImageDepthCorrelation;
  const cv::Mat gray = ReadGrayImage(entry.image_path, width_, height_);
  ImageF image(width_, height_);
  for (int y = 0; y < height_; ++y) {
    std::copy(gray.ptr<uint8_t>(y), gray.ptr<uint8_t>(y) + width_, image.row(y));
  }
  frame.image = BuildPyramid(std::move(image), kPyramidLevels);
  frame.inverse_virtual_depth = ReadInverseVirtualDepth(entry.depth_path, width_, height_);
  frame.sigma = ImageF(width_, height_, 0);
  cv::Mat sigma;
  if (!entry.sigma_path.empty()) sigma = Read16BitImage(entry.sigma_path, width_, height_);
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      if (frame.inverse_virtual_depth(x, y) == 0) continue;
      frame.sigma(x, y) = static_cast<float>(
          sigma.empty() ? default_sigma_ : sigma.at<uint16_t>(y, x) / 65535.0 * kMaxSigma);
      if (frame.sigma(x, y) == 0) frame.inverse_virtual_depth(x, y) = 0;
    }
  }
  return frame;
}

FocusedSequenceWriter::FocusedSequenceWriter(const std::string& folder)
    : folder_(folder), list_("# time image inverse_virtual_depth sigma\n") {
  for (const char* name : {"focused", "inverse_virtual_depth", "sigma"}) {
    CreateDirectory((std::filesystem::path(folder) / name).string());
  }
}

void FocusedSequenceWriter::Write(const LightFieldFrame& frame) {
  const std::string name = FrameFileName(count_++);
  const ImageF& image = frame.image[0];
  const cv::Mat view(
      image.height(), image.width(), CV_32FC1, const_cast<float*>(image.data()));  // NOLINT
  cv::Mat gray;
  view.convertTo(gray, CV_8U);
  const std::filesystem::path root(folder_);
  WriteImage((root / "focused" / name).string(), gray);
  WriteImage((root / "inverse_virtual_depth" / name).string(),
             Encode(frame.inverse_virtual_depth, frame.sigma, 1, -1));
  WriteImage((root / "sigma" / name).string(), Encode(frame.sigma, frame.sigma, 0, 1 / kMaxSigma));
  if (!frame.colour.empty()) {
    CreateDirectory((root / "colour").string());
    WriteImage((root / "colour" / name).string(), frame.colour);
  }
  list_ += FormatTime(frame.time_ns) + " focused/" + name + " inverse_virtual_depth/" + name +
           " sigma/" + name + "\n";
}

void FocusedSequenceWriter::Finish() {
  WriteTextAtomically((std::filesystem::path(folder_) / "focused.txt").string(), list_);
}

std::string FrameFileName(int frame) {
  char name[32];
  std::snprintf(name, sizeof(name), "%06d.png", frame);
  return name;
}

std::string FormatTime(int64_t time_ns) {
  char text[40];
  std::snprintf(text,
                sizeof(text),
                "%lld.%09lld",
                static_cast<long long>(time_ns / 1000000000),
                static_cast<long long>(time_ns % 1000000000));
  return text;
}

bool IsFocusedSequence(const std::string& folder) {
  return IsFile(InFolder(folder, "focused.txt"));
}

}  // namespace prism
