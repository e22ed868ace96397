// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/rgbd_sequence.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>
#include <tuple>
#include <utility>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "prism/base/error.h"
#include "prism/base/format.h"
#include "prism/io/atomic_file.h"
#include "prism/io/camera_file.h"
#include "prism/io/image_file.h"
#include "prism/io/time_list.h"

namespace prism {
namespace {

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

std::vector<double> ParsePinhole(const std::string& text) {
  // https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats
  const std::map<std::string, std::vector<double>> known = {
      {"ros_default", {525, 525, 319.5, 239.5}},
      {"freiburg1", {517.3, 516.5, 318.6, 255.3, 0.2624, -0.9531, -0.0054, 0.0026, 1.1633}},
      {"freiburg2", {520.9, 521.0, 325.1, 249.7, 0.2312, -0.7849, -0.0033, -0.0001, 0.9172}},
      {"freiburg3", {535.4, 539.2, 320.1, 247.6}}};
  const auto camera = known.find(text);
  if (camera != known.end()) return camera->second;
  std::vector<double> figures;
  std::istringstream stream(text);
  bool is_good = true;
  for (std::string word; std::getline(stream, word, ',');) {
    char* end = nullptr;
    figures.push_back(std::strtod(word.c_str(), &end));
    is_good = is_good && !word.empty() && *end == '\0' && std::isfinite(figures.back());
  }
  const size_t count = figures.size();
  if (!is_good || (count != 4 && count != 8 && count != 9)) {
    throw OptionError("pinhole",
                      "'" + text + "'",
                      "fx,fy,cx,cy[,k1,k2,p1,p2[,k3]] in px, freiburg1, freiburg2, freiburg3 or "
                      "ros_default");
  }
  return figures;
}

bool IsRgbdSequence(const std::string& folder) {
  return Exists(folder, "associations.txt") ||
         (Exists(folder, "rgb.txt") && Exists(folder, "depth.txt"));
}

RgbdSequence::RgbdSequence(const std::string& folder,
                           const PlenopticCamera& lens,
                           const RgbdConversionOptions& options,
                           const RgbdLayoutOptions& layout,
                           bool skip_missing)
    : folder_(folder), depth_factor_(layout.depth_factor), options_(options) {
  if (!IsFolder(folder)) {
    throw InputError(folder, "no such folder", "a sequence in TUM RGB-D layout");
  }
  if (layout.pinhole.empty()) {
    camera_ = PlenopticFromPinhole(ReadCamera(layout), lens);
    ReadEntries(skip_missing);
  } else {
    ReadEntries(skip_missing);  // an image of them tells the size
    camera_ = PlenopticFromPinhole(ReadCamera(layout), lens);
  }
}

PinholeCamera RgbdSequence::ReadCamera(const RgbdLayoutOptions& layout) {
  const std::string calibration = InFolder(folder_, "calibration.txt");
  PinholeCamera pinhole;
  std::vector<double> distortion;
  if (layout.pinhole.empty()) {
    if (!Exists(folder_, "calibration.txt")) {
      throw InputError(calibration, "no such file", "it, or --pinhole=fx,fy,cx,cy");
    }
    pinhole = ReadPinholeCamera(calibration);
  } else {
    const std::string first = InFolder(folder_, entries_.front().image_path);
    const cv::Mat image = ReadImageUnchanged(first);
    pinhole = {image.cols,
               image.rows,
               layout.pinhole[0],
               layout.pinhole[1],
               layout.pinhole[2],
               layout.pinhole[3]};
    std::string error;
    if (!pinhole.IsValid(&error)) throw OptionError("pinhole", error, "that of " + first);
    distortion.assign(layout.pinhole.begin() + 4, layout.pinhole.end());
  }
  const bool is_distorted =
      std::any_of(distortion.begin(), distortion.end(), [](double d) { return d != 0; });
  if (!is_distorted && std::abs(pinhole.fx - pinhole.fy) <= 1e-6 * pinhole.fx) return pinhole;
  PinholeCamera square = pinhole;
  square.fx = square.fy = 0.5 * (pinhole.fx + pinhole.fy);
  const auto matrix = [](const PinholeCamera& c) {
    return cv::Matx33d(c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
  };
  cv::initUndistortRectifyMap(matrix(pinhole),
                              distortion,
                              cv::noArray(),
                              matrix(square),
                              cv::Size(pinhole.width, pinhole.height),
                              CV_32FC1,
                              map_x_,
                              map_y_);
  return square;
}

void RgbdSequence::ReadEntries(bool skip_missing) {
  const std::string& folder = folder_;
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
  if (map_x_.empty()) return images;
  Images resampled;
  cv::remap(images.gray, resampled.gray, map_x_, map_y_, cv::INTER_LINEAR);
  // Depths of two surfaces have no mean.
  cv::remap(images.depth, resampled.depth, map_x_, map_y_, cv::INTER_NEAREST);
  return resampled;
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
  images.depth.convertTo(depth_m, CV_32F, 1 / depth_factor_);
  return PlenopticFrameFromRgbd(
      camera_, images.gray, depth_m, entry.time_ns, static_cast<uint64_t>(index), options_);
}

}  // namespace prism
