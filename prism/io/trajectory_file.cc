// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/trajectory_file.h"

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <vector>

#include <glog/logging.h>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"

namespace prism {
namespace {

constexpr double kSilentRotationError = 1e-4;
constexpr double kLargestRotationError = 0.05;
constexpr long double kLargestSeconds = 9.2e9L;  // what fits in 64 bits of nanoseconds

struct Line {
  int number = 0;  // from 1
  std::string text;
};

std::vector<Line> DataLines(const std::string& path) {
  const std::string contents = ReadTextFile(path);
  if (contents.find('\0') != std::string::npos) {
    throw InputError(path, "a binary file", "a trajectory, one pose a line");
  }
  std::vector<Line> lines;
  int number = 0;
  for (size_t begin = 0; begin < contents.size();) {
    const size_t end = std::min(contents.find('\n', begin), contents.size());
    ++number;
    std::string_view text(contents.data() + begin, end - begin);
    begin = end + 1;
    const size_t first = text.find_first_not_of(" \t\r,");
    if (first == std::string_view::npos || text[first] == '#') continue;
    lines.push_back({number, std::string(text)});
  }
  if (lines.empty()) throw InputError(path, "no pose", "a trajectory, one pose a line");
  return lines;
}

// Reads the numbers of one line in turn; separators are white space, commas and semicolons.
class LineParser {
 public:
  LineParser(const std::string& path, const Line& line, std::string expected)
      : path_(path), line_(line), expected_(std::move(expected)), next_(line.text.c_str()) {}

  double Number() {
    const double value = static_cast<double>(LongNumber());
    return value;
  }

  // Seconds as nanoseconds. A long double keeps all digits of a Unix time.
  int64_t SecondsAsNs() {
    const long double seconds = LongNumber();
    if (std::abs(seconds) > kLargestSeconds) Fail("a time of more than 292 years");
    return std::llroundl(seconds * 1e9L);
  }

  int64_t Nanoseconds() {
    SkipSeparators();
    char* end = nullptr;
    const int64_t value = std::strtoll(next_, &end, 10);
    if (end == next_ || *end == '.' || *end == 'e') Fail("'" + Token() + "'");
    next_ = end;
    return value;
  }

  void ExpectEnd() {
    SkipSeparators();
    if (*next_ != '\0') Fail("more columns ('" + Token() + "')");
  }

  [[noreturn]] void Fail(const std::string& found) const {
    throw InputError(path_ + ", line " + std::to_string(line_.number), found, expected_);
  }

 private:
  static bool IsSeparator(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == ',' || c == ';';
  }
  void SkipSeparators() {
    while (IsSeparator(*next_)) ++next_;
  }
  std::string Token() const {
    const char* end = next_;
    while (*end != '\0' && !IsSeparator(*end)) ++end;
    return std::string(next_, end);
  }
  long double LongNumber() {
    SkipSeparators();
    if (*next_ == '\0') Fail("too few columns");
    char* end = nullptr;
    const long double value = std::strtold(next_, &end);
    if (end == next_ || (*end != '\0' && !IsSeparator(*end)) || !std::isfinite(value)) {
      Fail("'" + Token() + "'");
    }
    next_ = end;
    return value;
  }

  const std::string& path_;
  const Line& line_;
  const std::string expected_;
  const char* next_;
};

int CountColumns(const std::string& text) {
  int count = 0;
  bool inside = false;
  for (const char c : text) {
    const bool is_space = c == ' ' || c == '\t' || c == '\r';
    if (!is_space && !inside) ++count;
    inside = !is_space;
  }
  return count;
}

TrajectoryFormat DetectFormat(const std::string& text) {
  if (text.find(',') != std::string::npos) return TrajectoryFormat::kEuroc;
  return CountColumns(text) == 12 ? TrajectoryFormat::kKitti : TrajectoryFormat::kTum;
}

// Collects how far rotations were from unit, to warn once a file.
struct RotationErrors {
  int count = 0;
  double largest = 0;

  void Add(double error) {
    if (error <= kSilentRotationError) return;
    ++count;
    largest = std::max(largest, error);
  }
};

SE3 CheckedPose(const Eigen::Quaterniond& rotation,
                const Eigen::Vector3d& translation,
                const LineParser& parser,
                RotationErrors* errors) {
  const double error = std::abs(rotation.norm() - 1);
  if (error > kLargestRotationError) {
    parser.Fail("a quaternion of norm " + std::to_string(rotation.norm()));
  }
  errors->Add(error);
  return SE3(rotation, translation);
}

StampedPose ParseTum(const std::string& path, const Line& line, RotationErrors* errors) {
  LineParser parser(path, line, "time tx ty tz qx qy qz qw with a unit quaternion");
  const int64_t time_ns = parser.SecondsAsNs();
  double v[7];
  for (double& value : v) value = parser.Number();
  parser.ExpectEnd();
  const Eigen::Quaterniond rotation(v[6], v[3], v[4], v[5]);
  return {time_ns, CheckedPose(rotation, {v[0], v[1], v[2]}, parser, errors)};
}

StampedPose ParseEuroc(const std::string& path, const Line& line, RotationErrors* errors) {
  LineParser parser(path, line, "time_ns,px,py,pz,qw,qx,qy,qz with a unit quaternion");
  const int64_t time_ns = parser.Nanoseconds();
  double v[7];
  for (double& value : v) value = parser.Number();
  const Eigen::Quaterniond rotation(v[3], v[4], v[5], v[6]);
  return {time_ns, CheckedPose(rotation, {v[0], v[1], v[2]}, parser, errors)};
}

StampedPose ParseKitti(const std::string& path,
                       const Line& line,
                       int64_t time_ns,
                       RotationErrors* errors) {
  LineParser parser(path, line, "the 12 numbers of [R | t] row by row with a rotation matrix R");
  Eigen::Matrix<double, 3, 4, Eigen::RowMajor> pose;
  for (Eigen::Index i = 0; i < pose.size(); ++i) pose.data()[i] = parser.Number();
  parser.ExpectEnd();
  const Eigen::Matrix3d R = pose.leftCols<3>();
  const double error = (R * R.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (error > kLargestRotationError || R.determinant() < 0) parser.Fail("no rotation matrix");
  errors->Add(error);
  return {time_ns, SE3(Eigen::Quaterniond(R), pose.col(3))};
}

std::vector<int64_t> KittiTimes(const TrajectoryReadOptions& options,
                                const std::string& path,
                                size_t pose_count) {
  std::vector<int64_t> times;
  if (options.kitti_times_path.empty()) {
    if (!(options.kitti_rate_hz > 0)) {
      throw InputError(path, "KITTI poses without times", "a file of times or a rate for them");
    }
    for (size_t i = 0; i < pose_count; ++i) {
      times.push_back(std::llround(1e9 * static_cast<double>(i) / options.kitti_rate_hz));
    }
    return times;
  }
  for (const Line& line : DataLines(options.kitti_times_path)) {
    LineParser parser(options.kitti_times_path, line, "one time in seconds");
    times.push_back(parser.SecondsAsNs());
    parser.ExpectEnd();
  }
  if (times.size() != pose_count) {
    throw InputError(options.kitti_times_path,
                     std::to_string(times.size()) + " times",
                     std::to_string(pose_count) + ", the number of poses in " + path);
  }
  return times;
}

}  // namespace

Trajectory ReadTrajectory(const std::string& path, const TrajectoryReadOptions& options) {
  const std::vector<Line> lines = DataLines(path);
  TrajectoryFormat format = options.format;
  if (format == TrajectoryFormat::kAuto) format = DetectFormat(lines.front().text);
  std::vector<int64_t> kitti_times;
  if (format == TrajectoryFormat::kKitti) kitti_times = KittiTimes(options, path, lines.size());

  Trajectory trajectory;
  trajectory.reserve(lines.size());
  RotationErrors errors;
  for (size_t i = 0; i < lines.size(); ++i) {
    StampedPose pose;
    if (format == TrajectoryFormat::kKitti) {
      pose = ParseKitti(path, lines[i], kitti_times[i], &errors);
    } else if (format == TrajectoryFormat::kEuroc) {
      pose = ParseEuroc(path, lines[i], &errors);
    } else {
      pose = ParseTum(path, lines[i], &errors);
    }
    if (!trajectory.empty() && pose.time_ns <= trajectory.back().time_ns) {
      const bool same = pose.time_ns == trajectory.back().time_ns;
      throw InputError(path + ", line " + std::to_string(lines[i].number),
                       same ? "the time of the pose before" : "a time before the previous one",
                       "times that increase");
    }
    trajectory.push_back(pose);
  }
  LOG_IF(WARNING, errors.count > 0)
      << path << ": " << errors.count << " rotations were not unit (by up to " << errors.largest
      << ") and were normalised";
  return trajectory;
}

std::string FormatTrajectory(const Trajectory& trajectory) {
  std::string text;
  text.reserve(trajectory.size() * 110);
  for (const StampedPose& pose : trajectory) {
    const Eigen::Vector3d t = pose.world_from_cam.translation();
    const Eigen::Quaterniond q = pose.world_from_cam.rotation();
    const int64_t magnitude_ns = std::abs(pose.time_ns);
    char line[256];
    std::snprintf(line,
                  sizeof(line),
                  "%s%" PRId64 ".%09" PRId64 " %.9g %.9g %.9g %.9g %.9g %.9g %.9g\n",
                  pose.time_ns < 0 ? "-" : "",
                  magnitude_ns / 1000000000,
                  magnitude_ns % 1000000000,
                  t.x(),
                  t.y(),
                  t.z(),
                  q.x(),
                  q.y(),
                  q.z(),
                  q.w());
    text += line;
  }
  return text;
}

void WriteTrajectory(const std::string& path, const Trajectory& trajectory) {
  WriteTextAtomically(path, FormatTrajectory(trajectory));
}

}  // namespace prism
