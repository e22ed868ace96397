// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/image_file.h"

#include <cstdint>
#include <filesystem>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"

namespace prism {
namespace {

cv::Mat Decode(const std::string& path, int flags) {
  if (!std::filesystem::is_regular_file(path)) {
    throw InputError(path, "no such file", "an image");
  }
  cv::Mat image = cv::imread(path, flags);
  if (image.empty()) throw InputError(path, "a file that does not decode", "an image");
  return image;
}

}  // namespace

void RequireImageSize(const std::string& path, const cv::Mat& image, int width, int height) {
  const auto text = [](int w, int h) { return std::to_string(w) + " x " + std::to_string(h); };
  if (image.cols != width || image.rows != height) {
    throw InputError(
        path, text(image.cols, image.rows) + " pixels", text(width, height) + " as the camera's");
  }
}

cv::Mat ReadGrayImage(const std::string& path, int width, int height) {
  cv::Mat image = Decode(path, cv::IMREAD_GRAYSCALE);
  RequireImageSize(path, image, width, height);
  return image;
}

cv::Mat Read16BitImage(const std::string& path, int width, int height) {
  cv::Mat image = Decode(path, cv::IMREAD_UNCHANGED);
  RequireImageSize(path, image, width, height);
  if (image.type() != CV_16UC1) {
    throw InputError(path,
                     std::to_string(image.channels()) + " channel(s) of " +
                         std::to_string(8 * image.elemSize1()) + " bits",
                     "one channel of 16 bits");
  }
  return image;
}

void WriteImage(const std::string& path, const cv::Mat& image) {
  // Encoded in memory: OpenCV does not report a disk that fills up while it writes.
  std::vector<uint8_t> bytes;
  const std::string extension = std::filesystem::path(path).extension().string();
  if (!cv::imencode(extension, image, bytes, {cv::IMWRITE_PNG_COMPRESSION, 1})) {
    throw InputError(path, "an image that does not encode", "a format for this pixel type");
  }
  WriteTextAtomically(path, std::string(bytes.begin(), bytes.end()));
}

cv::Mat ReadImageUnchanged(const std::string& path) { return Decode(path, cv::IMREAD_UNCHANGED); }

}  // namespace prism
