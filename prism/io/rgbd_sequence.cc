// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/rgbd_sequence.h"

#include <cmath>
#include <cstdlib>
#include <tuple>
#include <utility>

#include <opencv2/core.hpp>

#include "prism/base/error.h"
#include "prism/base/format.h"
#include "prism/io/atomic_file.h"
#include "prism/io/camera_file.h"
#include "prism/io/image_file.h"
#include "prism/io/time_list.h"

namespace prism {
namespace {

constexpr double kDepthUnitsPerMetre = 5000;
constexpr int64_t kMaxTimeDifferenceNs = 20'000'000;
// Of what somebody else has associated.
constexpr int64_t kMaxAssociatedNs = 100'000'000;

bool Exists(const std::string& folder, const char* name) { return IsFile(InFolder(folder, name)); }

std::string Milliseconds(int64_t ns) { return Format("%.1f ms", 1e-6 * static_cast<double>(ns)); }

// Images that nothing is made of, by their lines in a list.
struct LeftOut {
  std::vector<int> lines;
  int64_t first_distance_ns = 0;

  void Add(int line, int64_t distance_ns) {
    if (lines.empty()) first_distance_ns = distance_ns;
    lines.push_back(line);
  }
  std::string Text(const std::string& list, const char* partner) const {
    return list + ": " + std::to_string(lines.size()) + " images left out, whose nearest " +
           partner + " image is more than 20 ms away (the first: line " +
           std::to_string(lines.front()) + ", " + Milliseconds(first_distance_ns) + ")";
  }
};

}  // namespace

bool IsRgbdSequence(const std::string& folder) {
  return Exists(folder, "associations.txt") ||
         (Exists(folder, "rgb.txt") && Exists(folder, "depth.txt"));
}

RgbdSequence::RgbdSequence(const std::string& folder,
                           const PlenopticCamera& lens,
                           const RgbdConversionOptions& options,
                           bool skip_missing)
    : folder_(folder), options_(options) {
  if (!IsFolder(folder)) {
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
    ReadAssociations();
  } else if (IsRgbdSequence(folder)) {
    AssociateLists();
  } else {
    throw InputError(folder,
                     "neither associations.txt nor rgb.txt and depth.txt",
                     "a sequence in TUM RGB-D layout");
  }
  if (skip_missing) return;
  // A missing image is better known now than after half of the run.
  for (const Entry& entry : entries_) {
    for (const std::string& path : {entry.image_path, entry.depth_path}) {
      if (!Exists(folder, path.c_str())) {
        throw InputError(InFolder(folder, path), "no such file", "an image of the sequence");
      }
    }
  }
}

void RgbdSequence::ReadAssociations() {
  const std::string path = InFolder(folder_, "associations.txt");
  for (const TimedLine& line : ReadTimeList(path, 3)) {
    const std::string where = path + ":" + std::to_string(line.line_number);
    const int64_t distance = std::llabs(ParseTimeNs(line.words[1], where) - line.time_ns);
    if (distance > kMaxAssociatedNs) {
      throw InputError(where,
                       "a depth image " + Milliseconds(distance) + " from its colour image",
                       "one within 100 ms");
    }
    entries_.push_back({line.time_ns, line.words[0], line.words[2]});
  }
}

void RgbdSequence::AssociateLists() {
  const std::string image_list = InFolder(folder_, "rgb.txt");
  const std::string depth_list = InFolder(folder_, "depth.txt");
  const std::vector<TimedLine> images = ReadTimeList(image_list, 1);
  const std::vector<TimedLine> depths = ReadTimeList(depth_list, 1);
  const auto nearest = [](const std::vector<TimedLine>& lines, int64_t time_ns, size_t from) {
    const auto distance = [&](size_t i) { return std::llabs(lines[i].time_ns - time_ns); };
    while (from + 1 < lines.size() && distance(from + 1) <= distance(from)) ++from;
    return std::pair<size_t, int64_t>(from, distance(from));
  };
  LeftOut lone_depths, lone_images;
  size_t image = 0;
  for (const TimedLine& depth : depths) {
    int64_t distance = 0;
    std::tie(image, distance) = nearest(images, depth.time_ns, image);
    if (distance > kMaxTimeDifferenceNs) {
      lone_depths.Add(depth.line_number, distance);
      continue;
    }
    if (!entries_.empty() && entries_.back().time_ns == images[image].time_ns) continue;
    entries_.push_back({images[image].time_ns, images[image].words[0], depth.words[0]});
  }
  size_t depth = 0;
  for (const TimedLine& line : images) {
    int64_t distance = 0;
    std::tie(depth, distance) = nearest(depths, line.time_ns, depth);
    if (distance > kMaxTimeDifferenceNs) lone_images.Add(line.line_number, distance);
  }
  // Here and there one is missing; lists of two recordings are something else.
  if (2 * lone_depths.lines.size() >= depths.size()) {
    throw InputError(depth_list + ":" + std::to_string(lone_depths.lines.front()),
                     "a depth image whose nearest colour image is " +
                         Milliseconds(lone_depths.first_distance_ns) + " away, as are half of all",
                     "one within 20 ms in rgb.txt");
  }
  if (!lone_depths.lines.empty()) notes_.push_back(lone_depths.Text(depth_list, "colour"));
  if (!lone_images.lines.empty()) notes_.push_back(lone_images.Text(image_list, "depth"));
}

RgbdSequence::Images RgbdSequence::ReadImages(const Entry& entry) const {
  const int width = camera_.raw_width, height = camera_.raw_height;
  const std::string depth_path = InFolder(folder_, entry.depth_path);
  Images images = {ReadGrayImage(InFolder(folder_, entry.image_path), width, height),
                   Read16BitImage(depth_path, width, height)};
  if (cv::countNonZero(images.depth != 65535) == 0) {
    throw InputError(depth_path, "65535 everywhere", "depth (no measurement is 0)");
  }
  return images;
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
