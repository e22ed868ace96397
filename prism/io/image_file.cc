// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/image_file.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <string>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"

namespace prism {
namespace {

bool StartsWith(const std::string& bytes, const std::string& start) {
  return bytes.compare(0, start.size(), start) == 0;
}

// The formats frames come in. OpenCV knows others; a broken DICOM file, which has its mark behind
// whatever it starts with, ends the program there.
bool IsOfKnownFormat(const std::string& bytes) {
  constexpr const char* kStarts[] = {
      "\x89PNG", "\xff\xd8", "II*", "MM", "BM", "P1", "P2", "P3", "P4", "P5", "P6", "RIFF"};
  constexpr size_t kDicomMark = 128;
  if (bytes.size() > kDicomMark && bytes.compare(kDicomMark, 4, "DICM") == 0) return false;
  return std::any_of(std::begin(kStarts), std::end(kStarts), [&](const char* start) {
    return StartsWith(bytes, start);
  });
}

// Decoders fill what is missing of a JPEG file with gray, and say nothing.
bool IsCutJpeg(const std::string& bytes) {
  if (!StartsWith(bytes, "\xff\xd8")) return false;
  // Segments with their lengths (a thumbnail among them has an end of its own), then the scan, in
  // which the marker of the end does not occur.
  size_t at = 2;
  while (at + 3 < bytes.size() && bytes[at] == '\xff' && bytes[at + 1] != '\xda') {
    const auto byte = [&](size_t i) { return static_cast<size_t>(static_cast<uint8_t>(bytes[i])); };
    at += bytes[at + 1] == '\xff' ? 1 : 2 + 256 * byte(at + 2) + byte(at + 3);
  }
  return bytes.find("\xff\xd9", at) == std::string::npos;
}

cv::Mat Decode(const std::string& path, int flags) {
  if (!IsFile(path)) throw InputError(path, "no such file", "an image");
  const std::string bytes = ReadTextFile(path);
  if (bytes.empty()) throw InputError(path, "an empty file", "an image");
  if (IsCutJpeg(bytes)) throw InputError(path, "a JPEG file without its end", "a whole image");
  const auto fail = [&] {
    throw InputError(
        path, "a file that does not decode", "an image (PNG, JPEG, TIFF, BMP, PGM, PPM or WebP)");
  };
  if (!IsOfKnownFormat(bytes)) fail();
  cv::Mat image;
  try {
    const cv::Mat buffer(
        1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));  // NOLINT
    image = cv::imdecode(buffer, flags);
  } catch (const cv::Exception&) {  // for example a header of an absurd size
  }
  if (image.empty()) fail();
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
