// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/run_report.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <glog/logging.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "prism/eval/series.h"
#include "prism/io/atomic_file.h"
#include "prism/report/base64.h"
#include "prism/report/metrics_json.h"
#include "prism/report/report_page.h"

namespace prism {
namespace {

using Json = nlohmann::json;

constexpr size_t kMaxCloudPoints = 60000;
constexpr int kJpegQuality = 82;

double Seconds(int64_t time_ns) { return 1e-9 * static_cast<double>(time_ns); }

template <typename T>
std::string PackedBase64(const std::vector<T>& values) {
  return Base64(reinterpret_cast<const unsigned char*>(values.data()), values.size() * sizeof(T));
}

// Positions as one list x, y, z, x, ...; millimetres are enough for a picture.
Json PositionsToJson(const Trajectory& trajectory, const SE3& target_from_world) {
  Json list = Json::array();
  for (const StampedPose& pose : trajectory) {
    const Eigen::Vector3d p = target_from_world * pose.world_from_cam.translation();
    for (int i = 0; i < 3; ++i) list.push_back(std::round(p(i) * 1e4) / 1e4);
  }
  return list;
}

Json SeriesToJson(const std::vector<TimedValue>& series) {
  Json list = Json::array();
  for (const TimedValue& entry : series) list.push_back({Seconds(entry.time_ns), entry.value});
  return list;
}

Json CloudToJson(const std::vector<ReportCloudPoint>& cloud) {
  const size_t step = (cloud.size() + kMaxCloudPoints - 1) / kMaxCloudPoints;
  std::vector<float> positions;
  std::vector<uint8_t> intensities;
  for (size_t i = 0; i < cloud.size(); i += std::max<size_t>(step, 1)) {
    for (int k = 0; k < 3; ++k) positions.push_back(cloud[i].p_in_world(k));
    intensities.push_back(cloud[i].intensity);
  }
  return {{"positions", PackedBase64(positions)}, {"intensities", PackedBase64(intensities)}};
}

void AddGroundtruth(const RunReport& report, Json* json) {
  if (!report.metrics) return;
  (*json)["metrics"] = Json(MetricsToJson(*report.metrics));
  if (report.metrics->status != EvaluationStatus::kDone) return;
  const SE3& gt_from_estimate = report.metrics->gt_from_estimate;
  (*json)["groundtruth"] = PositionsToJson(report.groundtruth, gt_from_estimate.Inverse());
  const std::vector<PosePair> pairs = Associate(
      report.groundtruth, report.trajectory, HalfFrame(report.groundtruth, report.trajectory));
  (*json)["error"] = SeriesToJson(ErrorOverTime(pairs, gt_from_estimate));
  (*json)["scale"] = SeriesToJson(ScaleOverTime(pairs));
}

void ReplaceOnce(const std::string& marker, const std::string& text, std::string* page) {
  const size_t at = page->find(marker);
  CHECK_NE(at, std::string::npos) << marker;
  page->replace(at, marker.size(), text);
}

}  // namespace

double ThumbnailFactor(int image_width, int max_width) {
  CHECK_GT(max_width, 0);
  double factor = 1;
  while (image_width * factor > max_width) factor *= 0.5;
  return factor;
}

void SetThumbnail(ImageView<float> image, int max_width, ReportKeyframe* keyframe) {
  CHECK_GT(image.width, 0);
  cv::Mat gray;
  const cv::Mat source(image.height,
                       image.width,
                       CV_32FC1,
                       const_cast<float*>(image.data),
                       static_cast<size_t>(image.stride) * sizeof(float));
  source.convertTo(gray, CV_8U);
  const double factor = ThumbnailFactor(image.width, max_width);
  if (factor < 1) {
    const cv::Size size(std::max(1, static_cast<int>(image.width * factor)),
                        std::max(1, static_cast<int>(image.height * factor)));
    cv::resize(gray, gray, size, 0, 0, cv::INTER_AREA);
  }
  std::vector<unsigned char> bytes;
  CHECK(cv::imencode(".jpg", gray, bytes, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality}));
  keyframe->jpeg.assign(bytes.begin(), bytes.end());
  keyframe->width = gray.cols;
  keyframe->height = gray.rows;
}

std::vector<std::string> FindProblems(const std::vector<ReportFrame>& frames) {
  std::vector<std::string> problems;
  int segments = 0, joined = 0, held = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    joined += frames[i].is_joined;
    held += frames[i].is_held;
    if (frames[i].is_tracked) {
      segments = std::max(segments, frames[i].segment + 1);
      continue;
    }
    size_t last = i;
    while (last + 1 < frames.size() && !frames[last + 1].is_tracked &&
           frames[last + 1].status == frames[i].status) {
      ++last;
    }
    const std::string which = last == i
                                  ? "frame " + std::to_string(i)
                                  : "frames " + std::to_string(i) + " to " + std::to_string(last);
    problems.push_back(which + " not tracked (" + frames[i].status + ")");
    i = last;
  }
  if (held > 0) {
    problems.push_back(std::to_string(held) +
                       " frames show little and are held by the motion before them");
  }
  if (segments > 1) {
    std::string text = "the trajectory has " + std::to_string(segments) + " segments";
    if (joined > 0) text += ", " + std::to_string(joined) + " of them found again and joined";
    problems.push_back(text);
  }
  return problems;
}

Json FrameToReportJson(const ReportFrame& frame) {
  Json json = {{"t", Seconds(frame.time_ns)},
               {"status", frame.status},
               {"tracked", frame.is_tracked},
               {"keyframe", frame.is_keyframe},
               {"ms", Json::object()}};
  // Microseconds are enough, and a third of the digits.
  for (const auto& [stage, ms] : frame.stage_ms) json["ms"][stage] = std::round(ms * 1e3) / 1e3;
  if (!frame.is_tracked) return json;
  if (frame.points > 0) {  // a frame that begins a segment is not aligned to anything
    json["rms"] = frame.residual_rms;
    json["points"] = frame.points;
  }
  json["a"] = frame.brightness_a;
  json["b"] = frame.brightness_b;
  return json;
}

Json KeyframeToReportJson(const ReportKeyframe& keyframe) {
  const Eigen::Vector3d t = keyframe.world_from_cam.translation();
  const Eigen::Quaterniond q = keyframe.world_from_cam.rotation();
  std::vector<float> points;
  for (const ReportKeyframe::Point& point : keyframe.points) {
    for (const float value : {point.x, point.y, point.depth_m}) points.push_back(value);
  }
  Json json = {{"t", Seconds(keyframe.time_ns)},
               {"position", {t.x(), t.y(), t.z()}},
               {"rotation", {q.x(), q.y(), q.z(), q.w()}}};
  if (!points.empty()) json["points"] = PackedBase64(points);
  if (keyframe.jpeg.empty()) return json;
  json["jpeg"] =
      Base64(reinterpret_cast<const unsigned char*>(keyframe.jpeg.data()), keyframe.jpeg.size());
  json["width"] = keyframe.width;
  json["height"] = keyframe.height;
  return json;
}

Json ReportToJson(const RunReport& report) {
  Json json = {{"title", report.title},
               {"git_hash", report.git_hash},
               {"wall_seconds", report.wall_seconds},
               {"processor_seconds", report.processor_seconds},
               {"peak_resident_mib", report.peak_resident_mib},
               {"options", report.options},
               {"camera", report.camera},
               {"problems", FindProblems(report.frames)},
               {"trajectory", PositionsToJson(report.trajectory, SE3())},
               {"cloud", CloudToJson(report.cloud)}};
  json["frames"] = Json::array();
  for (const ReportFrame& frame : report.frames) json["frames"].push_back(FrameToReportJson(frame));
  json["keyframes"] = Json::array();
  for (const ReportKeyframe& keyframe : report.keyframes) {
    json["keyframes"].push_back(KeyframeToReportJson(keyframe));
  }
  if (!report.pieces.empty()) json["pieces"] = report.pieces;
  AddGroundtruth(report, &json);
  return json;
}

std::string FormatReport(const RunReport& report, bool live) {
  Json json = ReportToJson(report);
  json["live"] = live;
  // "</" would end the script element the data stand in, "<!--<script" swallow what follows it.
  std::string data = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  for (size_t at = data.find('<'); at != std::string::npos; at = data.find('<', at)) {
    data.replace(at, 1, "\\u003c");
  }
  std::string page = kReportPage;
  ReplaceOnce("%REPORT_DATA%", data, &page);
  return page;
}

void WriteReport(const std::string& path, const RunReport& report) {
  WriteTextAtomically(path, FormatReport(report));
}

}  // namespace prism
