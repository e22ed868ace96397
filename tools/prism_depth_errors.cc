// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gflags/gflags.h>
#include <opencv2/core/utility.hpp>

#include "prism/base/error.h"
#include "prism/base/version.h"
#include "prism/image/noise.h"
#include "prism/io/atomic_file.h"
#include "prism/io/focused_sequence.h"
#include "prism/lightfield/depth_conditions.h"
#include "prism/lightfield/light_field_processor.h"
#include "prism/odometry/options.h"
#include "prism/run/raw_input.h"
#include "tools/depth_error_report.h"
#include "tools/tool_main.h"

DEFINE_string(raw, "", "Folders of raw sequences (raw.txt), with commas between them.");
DEFINE_string(camera, "", "Camera file of all of them; camera.yaml of each folder if empty.");
DEFINE_string(micro_lens_grid, "", "Raytrix RayCalibData file, if the camera file has no grid.");
DEFINE_string(white_image,
              "",
              "White image; empty: white.png of the folder, else found on the frames; none: frames "
              "are taken as they are.");
DEFINE_string(colour, "auto", "auto, gray, colour, bayer_rggb, _bggr, _grbg or _gbrg.");
DEFINE_string(truth,
              "virtual_depth_truth",
              "Folder with true inverse virtual depth, NNNNNN.png by frame number: a name in each "
              "raw folder, or a path. Frames without truth are left out.");
DEFINE_double(min_depth_edge_distance_px,
              0,
              "Leave out points nearer to a depth edge of the truth, focused px, at most 30: what "
              "is left of other dependences.");
DEFINE_string(output_dir, "", "Folder for the results; created if missing.");
DEFINE_int32(threads, 2, "Threads; 0: one a core. The result does not depend on it.");

namespace prism {
namespace {

namespace fs = std::filesystem;

struct MeasuredPoint {
  Eigen::Vector2i px;
  double inverse_virtual_depth;
  double sigma;
};

// The points with a measured depth that the odometry starts a segment at this frame with.
std::vector<MeasuredPoint> PointsOfFirstKeyframe(const PlenopticCamera& camera,
                                                 std::shared_ptr<const LightFieldFrame> frame) {
  const OdometryOptions options;
  const TermList terms = MakeDefaultTerms(options.default_terms);
  Window window{PlenopticProjection(camera)};
  window.noise = NoiseModel(EstimateImageNoise(frame->image[0]), options.photometric_model_sigma);
  window.keyframes.push_back(std::make_unique<Keyframe>());
  window.newest().frame = std::move(frame);
  for (const auto& term : terms) term->AddStates(&window);
  ActivatePoints(options.activation, terms, options.window.max_points, &window);
  std::vector<MeasuredPoint> points;
  for (const auto& point : window.newest().points) {
    if (point->w_sigma == 0) continue;
    points.push_back({point->patch.px.cast<int>(), point->w_measured, point->w_sigma});
  }
  return points;
}

std::string CameraOf(const std::string& folder) {
  if (!FLAGS_camera.empty()) return FLAGS_camera;
  const fs::path path = fs::path(folder) / "camera.yaml";
  if (!fs::exists(path)) {
    throw InputError("--camera", "nothing", "a camera file, as " + path.string() + " is missing");
  }
  return path.string();
}

fs::path TruthOf(const std::string& folder) {
  for (const fs::path& path : {fs::path(folder) / FLAGS_truth, fs::path(FLAGS_truth)}) {
    if (fs::is_directory(path)) return path;
  }
  throw InputError((fs::path(folder) / FLAGS_truth).string(),
                   "no such folder",
                   "a folder of true inverse virtual depth");
}

// `id`: of the frame among those of all sequences.
DepthErrorFrame MeasureFrame(int number,
                             int id,
                             const RawFrame& raw,
                             const std::string& truth_path,
                             LightFieldProcessor* processor) {
  const auto frame = std::make_shared<const LightFieldFrame>(processor->Process(raw));
  const ImageF& depth = frame->inverse_virtual_depth;
  const ImageF truth = ReadInverseVirtualDepth(truth_path, depth.width(), depth.height());
  DepthErrorFrame result;
  result.number = number;
  std::vector<MeasuredPoint> points;
  std::vector<Eigen::Vector2i> pixels;
  for (const MeasuredPoint& point : PointsOfFirstKeyframe(processor->camera(), frame)) {
    if (truth(point.px.x(), point.px.y()) == 0) continue;
    points.push_back(point);
    pixels.push_back(point.px);
  }
  const std::vector<DepthConditions> conditions =
      MeasureDepthConditions(*processor, *frame, truth, pixels);
  for (size_t i = 0; i < points.size(); ++i) {
    const DepthConditions& of_point = conditions[i];
    if (std::abs(of_point.depth_edge_distance_px) < FLAGS_min_depth_edge_distance_px) continue;
    const double error = points[i].inverse_virtual_depth - of_point.true_inverse_virtual_depth;
    result.errors.push_back({id, error, points[i].sigma});
    result.conditions.push_back(of_point);
  }
  return result;
}

DepthErrorSequence MeasureSequence(const std::string& folder, int* num_frames) {
  const fs::path truth = TruthOf(folder);
  RawInput input = OpenRawInput({folder,
                                 CameraOf(folder),
                                 FLAGS_micro_lens_grid,
                                 FLAGS_white_image,
                                 FLAGS_colour,
                                 FLAGS_threads});
  std::cout << folder << ": " << input.grid_report << std::endl;
  LightFieldProcessor processor(input.camera, input.white, input.options);
  DepthErrorSequence sequence;
  sequence.folder = folder;
  for (int i = 0; i < input.sequence->size(); ++i) {
    const fs::path path = truth / FrameFileName(i);
    if (!fs::exists(path)) continue;
    sequence.frames.push_back(
        MeasureFrame(i, (*num_frames)++, input.sequence->Read(i), path.string(), &processor));
  }
  if (sequence.frames.empty()) {
    throw InputError(truth.string(), "no truth of any frame", FrameFileName(0) + " or another");
  }
  return sequence;
}

ExitStatus Run() {
  RequireFlag("raw", FLAGS_raw, "folders of raw sequences");
  RequireFlag("output_dir", FLAGS_output_dir, "a folder for the results");
  if (!(FLAGS_min_depth_edge_distance_px >= 0 && FLAGS_min_depth_edge_distance_px <= 30)) {
    throw InputError("--min_depth_edge_distance_px",
                     std::to_string(FLAGS_min_depth_edge_distance_px),
                     "0 to 30");
  }
  cv::setNumThreads(FLAGS_threads > 0 ? FLAGS_threads : -1);
  std::vector<DepthErrorSequence> sequences;
  int num_frames = 0;
  for (const std::string& folder : SplitAtCommas(FLAGS_raw)) {
    sequences.push_back(MeasureSequence(folder, &num_frames));
  }
  const std::vector<DepthErrorDependence> dependences = AnalyzeDepthErrors(sequences);
  if (dependences.empty()) {
    std::cerr << "prism_depth_errors: too few points with measured and true depth" << std::endl;
    return kExitRunFailed;
  }
  std::cout << "\n" << FormatDepthErrors(sequences, dependences);

  CreateDirectory(FLAGS_output_dir);
  const fs::path output(FLAGS_output_dir);
  nlohmann::ordered_json json = DepthErrorsToJson(sequences, dependences);
  json["version"] = kVersion;
  json["git_hash"] = GitRevision();
  json["options"] = EffectiveOptions();
  WriteTextAtomically((output / "depth_errors.json").string(), json.dump(1) + "\n");
  PlotDepthErrors((output / "depth_errors").string(), dependences);
  return kExitDone;
}

}  // namespace
}  // namespace prism

int main(int argc, char** argv) {
  return prism::RunTool(
      {"prism_depth_errors",
       "how the error of measured 1/v depends on circumstances, at the points the odometry uses.",
       "--raw=FOLDER[,FOLDER...] [--camera=FILE] [--micro_lens_grid=FILE] [--truth=FOLDER] "
       "--output_dir=FOLDER",
       "prism_depth_errors --raw=out/kitchen,out/desk --output_dir=out/depth_errors"},
      argc,
      argv,
      prism::Run);
}
