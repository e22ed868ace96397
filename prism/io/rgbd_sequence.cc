// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/rgbd_sequence.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"
#include "prism/io/camera_file.h"
#include "prism/io/image_file.h"
#include "prism/io/time_list.h"

namespace prism {
namespace {

constexpr double kDepthUnitsPerMetre = 5000;
constexpr int64_t kMaxTimeDifferenceNs = 20'000'000;

bool Exists(const std::string& folder, const char* name) {
  return std::filesystem::is_regular_file(InFolder(folder, name));
}

}  // namespace

bool IsRgbdSequence(const std::string& folder) {
  return Exists(folder, "associations.txt") ||
         (Exists(folder, "rgb.txt") && Exists(folder, "depth.txt"));
}

RgbdSequence::RgbdSequence(const std::string& folder,
                           const PlenopticCamera& lens,
                           const RgbdConversionOptions& options)
    : folder_(folder), options_(options) {
  if (!std::filesystem::is_directory(folder)) {
    throw InputError(folder, "no such folder", "a sequence in TUM RGB-D layout");
  }
  const std::string calibration = InFolder(folder, "calibration.txt");
  const PinholeCamera pinhole = ReadPinholeCamera(calibration);
  if (std::abs(pinhole.fx - pinhole.fy) > 1e-6 * pinhole.fx) {
    throw InputError(calibration,
                     "fx = " + std::to_string(pinhole.fx) + ", fy = " + std::to_string(pinhole.fy),
                     "square pixels (fx = fy)");
  }
  camera_ = PlenopticFromPinhole(pinhole, lens);

  if (Exists(folder, "associations.txt")) {
    const std::string path = InFolder(folder, "associations.txt");
    for (const TimedLine& line : ReadTimeList(path, 3)) {
      ParseTimeNs(line.words[1], path + ":" + std::to_string(line.line_number));
      entries_.push_back({line.time_ns, line.words[0], line.words[2]});
    }
  } else if (IsRgbdSequence(folder)) {
    const std::vector<TimedLine> images = ReadTimeList(InFolder(folder, "rgb.txt"), 1);
    size_t image = 0;
    const std::string depth_list = InFolder(folder, "depth.txt");
    for (const TimedLine& depth : ReadTimeList(depth_list, 1)) {
      const auto distance = [&](size_t i) { return std::llabs(images[i].time_ns - depth.time_ns); };
      while (image + 1 < images.size() && distance(image + 1) <= distance(image)) ++image;
      if (distance(image) > kMaxTimeDifferenceNs) {
        throw InputError(depth_list + ":" + std::to_string(depth.line_number),
                         "a depth image whose nearest colour image is " +
                             std::to_string(1e-6 * static_cast<double>(distance(image))) +
                             " ms away",
                         "one within 20 ms in rgb.txt");
      }
      if (!entries_.empty() && entries_.back().time_ns == images[image].time_ns) continue;
      entries_.push_back({images[image].time_ns, images[image].words[0], depth.words[0]});
    }
  } else {
    throw InputError(folder,
                     "neither associations.txt nor rgb.txt and depth.txt",
                     "a sequence in TUM RGB-D layout");
  }
  // A missing image is better known now than after half of the run.
  for (const Entry& entry : entries_) {
    for (const std::string& path : {entry.image_path, entry.depth_path}) {
      if (!Exists(folder, path.c_str())) {
        throw InputError(InFolder(folder, path), "no such file", "an image of the sequence");
      }
    }
  }
}

RgbdSequence::Images RgbdSequence::ReadImages(const Entry& entry) const {
  const int width = camera_.raw_width, height = camera_.raw_height;
  return {ReadGrayImage(InFolder(folder_, entry.image_path), width, height),
          Read16BitImage(InFolder(folder_, entry.depth_path), width, height)};
}

LightFieldFrame RgbdSequence::Read(int index, StageTimer* timer) const {
  const Entry& entry = entries_.at(index);
  Images images;
  {
    const StageTimer::Scope scope(timer, "read image");
    images = ReadImages(entry);
  }
  const StageTimer::Scope scope(timer, "convert frame");
  cv::Mat depth_m;
  images.depth.convertTo(depth_m, CV_32F, 1 / kDepthUnitsPerMetre);
  return PlenopticFrameFromRgbd(
      camera_, images.gray, depth_m, entry.time_ns, static_cast<uint64_t>(index), options_);
}

}  // namespace prism
