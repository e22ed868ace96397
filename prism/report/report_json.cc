// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <set>

#include "prism/base/format.h"
#include "prism/base/statistics.h"
#include "prism/eval/series.h"
#include "prism/io/trajectory_file.h"
#include "prism/report/base64.h"
#include "prism/report/metrics_json.h"
#include "prism/report/run_report.h"

namespace prism {
namespace {

using Json = nlohmann::json;

// Together they leave a page below 20 MB (PageStaysBelow20MbHoweverLongTheRun).
constexpr size_t kMaxFrames = 6000;
constexpr size_t kMaxGroundtruth = 10000;
constexpr size_t kMaxDownload = 15000;  // poses
constexpr size_t kMaxKeyframes = 2000;
constexpr size_t kMaxPictureBytes = 7000000;
constexpr size_t kMaxCloudPoints = 60000;
constexpr size_t kMaxDensePoints = 120000;

double Seconds(int64_t time_ns) { return 1e-9 * static_cast<double>(time_ns); }

double Rounded(double value, double steps) { return std::round(value * steps) / steps; }

// Every so many of `count` are at most `most`.
size_t StepTo(size_t count, size_t most) { return std::max<size_t>((count + most - 1) / most, 1); }

template <typename T>
std::vector<T> TakeEvenly(const std::vector<T>& values, size_t most) {
  const size_t step = StepTo(values.size(), most);
  std::vector<T> taken;
  for (size_t i = 0; i < values.size(); i += step) taken.push_back(values[i]);
  return taken;
}

template <typename T>
std::string PackedBase64(const std::vector<T>& values) {
  return Base64(reinterpret_cast<const unsigned char*>(values.data()), values.size() * sizeof(T));
}

std::string TextBase64(const std::string& bytes) {
  return Base64(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
}

// Positions as one list x, y, z, x, ...; 0.1 mm is enough for a picture.
Json PositionsToJson(const Trajectory& trajectory, const SE3& target_from_world) {
  Json list = Json::array();
  for (const StampedPose& pose : trajectory) {
    const Eigen::Vector3d p = target_from_world * pose.world_from_cam.translation();
    for (int i = 0; i < 3; ++i) list.push_back(Rounded(p(i), 1e4));
  }
  return list;
}

Json SeriesToJson(const std::vector<TimedValue>& series) {
  Json list = Json::array();
  for (const TimedValue& entry : TakeEvenly(series, kMaxFrames)) {
    list.push_back({Seconds(entry.time_ns), Rounded(entry.value, 1e6)});
  }
  return list;
}

Json CloudToJson(const std::vector<ReportCloudPoint>& cloud) {
  std::vector<float> positions;
  std::vector<uint8_t> colors;
  for (const ReportCloudPoint& point : cloud) {
    for (int k = 0; k < 3; ++k) positions.push_back(point.p_in_world(k));
    colors.insert(colors.end(), point.rgb.begin(), point.rgb.end());
  }
  return {{"positions", PackedBase64(positions)}, {"colors", PackedBase64(colors)}};
}

// As a page makes it of the frames it has: of runs it has only some frames of.
Json StagesToJson(const std::vector<ReportFrame>& frames) {
  std::map<std::string, std::vector<double>> stages;
  for (const ReportFrame& frame : frames) {
    for (const auto& [stage, ms] : frame.stage_ms) stages[stage].push_back(ms);
  }
  Json json = Json::object();
  for (const auto& [stage, ms] : stages) {
    double total = 0;
    for (const double value : ms) total += value;
    json[stage] = {{"count", ms.size()},
                   {"median", Quantile(ms, 0.5)},
                   {"largest", *std::max_element(ms.begin(), ms.end())},
                   {"total", total}};
  }
  return json;
}

std::string SaysEvery(size_t step, size_t count, const char* what) {
  return Format("one in %zu of the %zu %s is shown", step, count, what);
}

void AddGroundtruth(const RunReport& report, Json* json) {
  if (!report.metrics) return;
  (*json)["metrics"] = Json(MetricsToJson(*report.metrics));
  if (report.metrics->status != EvaluationStatus::kDone) return;
  const SE3& gt_from_estimate = report.metrics->gt_from_estimate;
  (*json)["groundtruth"] =
      PositionsToJson(TakeEvenly(report.groundtruth, kMaxGroundtruth), gt_from_estimate.Inverse());
  const std::vector<PosePair> pairs = Associate(
      report.groundtruth, report.trajectory, HalfFrame(report.groundtruth, report.trajectory));
  (*json)["error"] = SeriesToJson(ErrorOverTime(pairs, gt_from_estimate));
  (*json)["scale"] = SeriesToJson(ScaleOverTime(pairs));
}

// Frames, and the poses of those that have one.
void AddFrames(const RunReport& report, Json* json, std::vector<std::string>* left_out) {
  const size_t step = StepTo(report.frames.size(), kMaxFrames);
  (*json)["frame_step"] = step;
  (*json)["frame_count"] = report.frames.size();
  size_t tracked = 0, keyframes = 0;
  for (const ReportFrame& frame : report.frames) {
    tracked += frame.is_tracked;
    keyframes += frame.is_keyframe;
  }
  (*json)["tracked_count"] = tracked;
  (*json)["keyframe_count"] = keyframes;
  (*json)["frames"] = Json::array();
  std::set<int64_t> times;
  for (size_t i = 0; i < report.frames.size(); i += step) {
    (*json)["frames"].push_back(FrameToReportJson(report.frames[i]));
    times.insert(report.frames[i].time_ns);
  }
  Trajectory shown;
  std::vector<int> pieces;
  for (size_t i = 0; i < report.trajectory.size(); ++i) {
    if (step > 1 && times.count(report.trajectory[i].time_ns) == 0) continue;
    shown.push_back(report.trajectory[i]);
    if (!report.pieces.empty()) pieces.push_back(report.pieces[i]);
  }
  (*json)["trajectory"] = PositionsToJson(shown, SE3());
  if (!pieces.empty()) (*json)["pieces"] = pieces;
  if (step > 1) {
    left_out->push_back(SaysEvery(step, report.frames.size(), "frames") +
                        "; problems and stage times are those of all");
    (*json)["stages"] = StagesToJson(report.frames);
  }
  if (report.trajectory.size() <= kMaxDownload) {
    (*json)["trajectory_tum"] = FormatTrajectory(report.trajectory);
  } else {
    left_out->push_back("the trajectory to download is in trajectory.txt beside this page");
  }
}

void AddKeyframes(const RunReport& report, Json* json, std::vector<std::string>* left_out) {
  // Those with a picture come before those without.
  size_t bytes = 0, pictures = 0;
  for (const ReportKeyframe& keyframe : report.keyframes) {
    bytes += keyframe.PictureBytes();
    pictures += !keyframe.jpeg.empty();
  }
  size_t picture_step = 1;
  while (bytes > kMaxPictureBytes || pictures > kMaxKeyframes) {
    ++picture_step;
    bytes = pictures = 0;
    size_t number = 0;
    for (const ReportKeyframe& keyframe : report.keyframes) {
      if (keyframe.jpeg.empty() || number++ % picture_step != 0) continue;
      bytes += keyframe.PictureBytes();
      ++pictures;
    }
  }
  const size_t others = report.keyframes.size() - pictures;
  const size_t step = StepTo(others, kMaxKeyframes);
  (*json)["keyframes"] = Json::array();
  size_t number = 0, other = 0;
  for (const ReportKeyframe& keyframe : report.keyframes) {
    ReportKeyframe shown = keyframe;
    if (keyframe.jpeg.empty() || number++ % picture_step != 0) {
      if (other++ % step != 0) continue;
      shown.DropPictures();
    }
    (*json)["keyframes"].push_back(KeyframeToReportJson(shown));
  }
  if (others > 0) {
    left_out->push_back(Format(
        "%zu of the %zu keyframes have their picture here", pictures, report.keyframes.size()));
  }
  const size_t shown = (*json)["keyframes"].size();
  if (shown < report.keyframes.size()) {
    left_out->push_back(
        Format("%zu keyframes without picture are not shown", report.keyframes.size() - shown));
  }
}

void AddCloud(const std::vector<ReportCloudPoint>& cloud,
              const char* name,
              const char* what,
              size_t most,
              Json* json,
              std::vector<std::string>* left_out) {
  (*json)[name] = CloudToJson(TakeEvenly(cloud, most));
  const size_t step = StepTo(cloud.size(), most);
  if (step > 1) left_out->push_back(SaysEvery(step, cloud.size(), what));
}

Json MapToJson(const ReportMap& map) {
  return {{"png", TextBase64(map.png)},
          {"low", map.low},
          {"high", map.high},
          {"levels", ReportMap::kLevels}};
}

}  // namespace

Json FrameToReportJson(const ReportFrame& frame) {
  Json json = {{"t", Seconds(frame.time_ns)},
               {"status", frame.status},
               {"tracked", frame.is_tracked},
               {"keyframe", frame.is_keyframe},
               {"ms", Json::object()}};
  // Microseconds are enough, and a third of the digits.
  for (const auto& [stage, ms] : frame.stage_ms) json["ms"][stage] = Rounded(ms, 1e3);
  if (!frame.is_tracked) return json;
  if (frame.points > 0) {  // a frame that begins a segment is not aligned to anything
    json["rms"] = Rounded(frame.residual_rms, 1e4);
    json["points"] = frame.points;
  }
  json["a"] = Rounded(frame.brightness_a, 1e6);
  json["b"] = Rounded(frame.brightness_b, 1e4);
  if (frame.scale_sigma > 0) json["scale_sigma"] = Rounded(frame.scale_sigma, 1e6);
  return json;
}

Json KeyframeToReportJson(const ReportKeyframe& keyframe) {
  const Eigen::Vector3d t = keyframe.world_from_cam.translation();
  const Eigen::Quaterniond q = keyframe.world_from_cam.rotation();
  std::vector<float> points;
  for (const ReportKeyframe::Point& point : keyframe.points) {
    for (const float value : {point.x, point.y, point.depth_m, point.residual}) {
      points.push_back(value);
    }
  }
  Json json = {
      {"t", Seconds(keyframe.time_ns)},
      {"position", {Rounded(t.x(), 1e6), Rounded(t.y(), 1e6), Rounded(t.z(), 1e6)}},
      {"rotation",
       {Rounded(q.x(), 1e6), Rounded(q.y(), 1e6), Rounded(q.z(), 1e6), Rounded(q.w(), 1e6)}}};
  if (!points.empty()) json["points"] = PackedBase64(points);
  if (!keyframe.inverse_virtual_depth.png.empty()) {
    json["inverse_virtual_depth"] = MapToJson(keyframe.inverse_virtual_depth);
    json["sigma"] = MapToJson(keyframe.sigma);
  }
  if (keyframe.jpeg.empty()) return json;
  json["jpeg"] = TextBase64(keyframe.jpeg);
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
               {"notes", report.notes},
               {"view", {report.view_x, report.view_y}}};
  if (report.scale_sigma) json["scale_sigma"] = *report.scale_sigma;
  std::vector<std::string> left_out;
  AddFrames(report, &json, &left_out);
  AddKeyframes(report, &json, &left_out);
  AddCloud(report.cloud, "cloud", "points", kMaxCloudPoints, &json, &left_out);
  if (!report.dense.empty()) {
    AddCloud(report.dense, "dense", "points of fused depth", kMaxDensePoints, &json, &left_out);
  }
  AddGroundtruth(report, &json);
  json["left_out"] = left_out;
  return json;
}

}  // namespace prism
