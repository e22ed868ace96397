// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <optional>

#include <gflags/gflags.h>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>

#include "prism/base/error.h"
#include "prism/base/version.h"
#include "prism/camera/projection.h"
#include "prism/io/atomic_file.h"
#include "prism/io/camera_file.h"
#include "prism/io/focused_sequence.h"
#include "prism/io/image_file.h"
#include "prism/lightfield/depth_accuracy.h"
#include "prism/lightfield/light_field_processor.h"
#include "prism/lightfield/pinhole_view.h"
#include "prism/lightfield/reprojection.h"
#include "prism/lightfield/verdict.h"
#include "prism/lightfield/with_threads.h"
#include "prism/run/folder_contents.h"
#include "prism/run/micro_lens_estimation.h"
#include "prism/run/raw_input.h"
#include "tools/rgbd_writer.h"
#include "tools/tool_main.h"
#include "tools/unreadable_frames.h"
#include "tools/verdict_json.h"

DEFINE_string(raw, "", "Folder of a raw sequence (raw.txt).");
DEFINE_string(camera, "", "Camera file; empty: camera.yaml or CameraModel.xml of the folder.");
DEFINE_string(
    micro_lens_grid,
    "",
    "Raytrix RayCalibData file, if the camera file has no grid; empty: MLA_Calibration.xml of "
    "the folder.");
DEFINE_string(white_image,
              "",
              "White image; empty: white.png of the folder, else found on the frames; none: frames "
              "are taken as they are.");
DEFINE_string(colour, "auto", "auto, gray, colour, bayer_rggb, _bggr, _grbg or _gbrg.");
DEFINE_string(focused_image,
              "virtual_points",
              "What a pixel shows: virtual_points, or chief_rays as prism_vo has it (an image that "
              "depth taken wrongly does not displace). The camera file written says which.");
DEFINE_bool(focus_colour,
            false,
            "Focused images and pinhole views in colour as well, of colour and Bayer frames; takes "
            "three focused images more.");
DEFINE_string(output_dir, "", "Folder for the results; created if missing.");
DEFINE_string(truth, "", "Folder with true inverse virtual depth, NNNNNN.png by frame number.");
DEFINE_string(export_rgbd, "", "Folder for the pinhole view as TUM RGB-D; default: pinhole/.");
DEFINE_bool(depth_tiff,
            false,
            "Measured depth as 32-bit float TIFF as well, depth_m/NNNNNN.tif: metres from the main "
            "lens along the axis, 0 = none, on the grid of the focused images.");
DEFINE_double(crop_fov_deg, 0, "Field of view the pinhole view is cropped to; 0: not cropped.");
DEFINE_bool(
    estimate_grid,
    false,
    "Only find the micro lenses: their grid in --white_image or --raw, their mode and types "
    "in --raw. --camera with them goes to --camera_out.");
DEFINE_string(camera_out, "", "Camera file (native YAML) written by --estimate_grid.");
DEFINE_int32(max_frames, 0, "Number of frames to process; 0: all.");
DEFINE_int32(threads, 2, "Threads; 0: one a core. The result does not depend on it.");
DEFINE_double(min_inverse_virtual_depth,
              0,
              "Smallest 1/v searched; 0: that of 0.2 m, but 0.05 at least and 0.1 at most.");
DEFINE_double(max_inverse_virtual_depth, 0.48, "Largest 1/v searched, at most 0.5.");

namespace prism {
namespace {

void ApplyFlags(LightFieldOptions* changed) {
  LightFieldOptions& options = *changed;
  options.depth.min_inverse_virtual_depth = FLAGS_min_inverse_virtual_depth;
  options.depth.max_inverse_virtual_depth = FLAGS_max_inverse_virtual_depth;
  std::string error;
  if (!options.IsValid(&error)) throw InputError("command line", error, "valid options");
  if (!(FLAGS_crop_fov_deg >= 0 && FLAGS_crop_fov_deg < 180)) {
    throw InputError("--crop_fov_deg", std::to_string(FLAGS_crop_fov_deg), "0 to 180");
  }
}

RawInputOptions InputOptions() {
  return {FLAGS_raw,
          FLAGS_camera,
          FLAGS_micro_lens_grid,
          FLAGS_white_image,
          FLAGS_colour,
          FLAGS_threads,
          FLAGS_focus_colour,
          /*rate_hz=*/0,
          /*skip_missing=*/false,
          FocusedImageOf(FLAGS_focused_image)};
}

// Camera and grid that were not given, and a line about each.
void TakeFromFolder(RawInputOptions* options) {
  SequenceOptions sequence;
  sequence.sequence = options->folder;
  sequence.camera = options->camera;
  sequence.micro_lens_grid = options->micro_lens_grid;
  std::vector<std::string> report;
  sequence = CompleteFromFolder(sequence, "raw", &report);
  options->camera = sequence.camera;
  options->micro_lens_grid = sequence.micro_lens_grid;
  for (const std::string& line : report) std::cout << line << std::endl;
}

ExitStatus EstimateGridOnly() {
  RequireFlag("camera", FLAGS_camera, "a camera file");
  RequireFlag("camera_out", FLAGS_camera_out, "a camera file to write");
  const MicroLensEstimate estimate = EstimateMicroLenses(InputOptions());
  WriteNativeCamera(FLAGS_camera_out, estimate.camera);
  std::cout << estimate.report << "written to " << FLAGS_camera_out << std::endl;
  return kExitDone;
}

nlohmann::json TimesToJson(const StageTimer& timer) {
  nlohmann::json stages;
  for (const auto& [stage, summary] : timer.Summarize()) {
    stages[stage] = {{"median_ms", summary.median_ms},
                     {"p95_ms", summary.p95_ms},
                     {"total_ms", summary.total_ms}};
  }
  return stages;
}

nlohmann::json AccuracyToJson(const DepthAccuracyEvaluator& evaluator) {
  nlohmann::json list = nlohmann::json::array();
  std::printf(
      "percent  pixels   median |e|  median e   |e|>0.02  normalised sigma   (%.1f %% measured)\n",
      100 * evaluator.MeasuredFraction());
  for (const DepthAccuracy& a : evaluator.Evaluate()) {
    std::printf("%5.0f %9ld   %.5f    %+.5f    %.4f    %.3f\n",
                a.percent,
                a.pixels,
                a.median_abs_error,
                a.median_error,
                a.fraction_above_0_02,
                a.normalized_sigma);
    list.push_back({{"percent", a.percent},
                    {"pixels", a.pixels},
                    {"median_abs_error", a.median_abs_error},
                    {"median_error", a.median_error},
                    {"fraction_above_0_02", a.fraction_above_0_02},
                    {"normalized_sigma", a.normalized_sigma}});
  }
  return list;
}

nlohmann::json ReprojectionToJson(const LightFieldProcessor& processor,
                                  const LightFieldFrame& frame) {
  constexpr double kTextured = 3;  // gradient per focused px over the noise
  const double noise = processor.noise();
  const ReprojectionError error = MeasureReprojection(processor.camera(),
                                                      processor.lenses(),
                                                      processor.prepared(),
                                                      frame,
                                                      processor.dense_inverse_virtual_depth(),
                                                      kTextured * noise);
  std::printf(
      "focused image against the first raw frame: RMS %.2f on %ld textured pixels, noise "
      "%.2f\n",
      error.rms,
      error.pixels,
      noise);
  return {{"rms", error.rms}, {"pixels", error.pixels}, {"noise", noise}};
}

void AddTruth(int frame, const LightFieldFrame& result, DepthAccuracyEvaluator* evaluator) {
  const std::filesystem::path path = std::filesystem::path(FLAGS_truth) / FrameFileName(frame);
  if (!std::filesystem::exists(path)) return;
  const ImageF& depth = result.inverse_virtual_depth;
  evaluator->Add(
      depth, result.sigma, ReadInverseVirtualDepth(path.string(), depth.width(), depth.height()));
}

void WriteDepthTiff(int frame, const PlenopticCamera& camera, const ImageF& w) {
  const PlenopticProjection projection(camera);
  cv::Mat depth(w.height(), w.width(), CV_32FC1, cv::Scalar(0));
  for (int y = 0; y < w.height(); ++y) {
    for (int x = 0; x < w.width(); ++x) {
      if (w(x, y) == 0) continue;
      const double rho = InverseDepth(projection, w(x, y));
      if (rho > 0) depth.at<float>(y, x) = static_cast<float>(1 / rho);
    }
  }
  const std::filesystem::path folder = std::filesystem::path(FLAGS_output_dir) / "depth_m";
  CreateDirectory(folder.string());
  WriteImage((folder / FrameFileName(frame)).replace_extension(".tif").string(), depth);
}

ExitStatus ProcessSequence() {
  RequireFlag("raw", FLAGS_raw, "the folder of a raw sequence");
  RequireFlag("output_dir", FLAGS_output_dir, "a folder for the results");
  if (FLAGS_max_frames < 0) {
    throw InputError("--max_frames", std::to_string(FLAGS_max_frames), "0 (all) or more");
  }
  RawInputOptions input_options = InputOptions();
  TakeFromFolder(&input_options);
  RawInput input = OpenRawInput(input_options);
  cv::setNumThreads(FLAGS_threads > 0 ? FLAGS_threads : -1);
  if (FLAGS_depth_tiff) RequireMetricDepth(input.camera, input_options.camera);
  ApplyFlags(&input.options);
  std::cout << input.grid_report << std::endl;
  if (!FLAGS_truth.empty() && input_options.focused_image != FocusedImage::kVirtualPoints) {
    throw InputError(
        "--truth", "given with --focused_image=chief_rays", "virtual_points, which truth is of");
  }
  if (!FLAGS_truth.empty() && !IsFolder(FLAGS_truth)) {
    throw InputError(FLAGS_truth, "no such folder", "a folder of true inverse virtual depth");
  }

  LightFieldProcessor processor(input.camera, input.white, input.options);
  input.white.release();
  const std::filesystem::path output(FLAGS_output_dir);
  FocusedSequenceWriter writer(FLAGS_output_dir);
  RgbdWriter pinhole(FLAGS_export_rgbd.empty() ? (output / "pinhole").string() : FLAGS_export_rgbd,
                     PinholeView(input.camera),
                     FLAGS_crop_fov_deg);
  DepthAccuracyEvaluator evaluator;
  LightFieldVerdict verdict;
  nlohmann::json json;
  StageTimer frame_timer;
  const int size = input.sequence->size();
  const int count = FLAGS_max_frames > 0 ? std::min(FLAGS_max_frames, size) : size;
  UnreadableFrames unreadable(FLAGS_raw, count);
  for (int i = 0; i < count; ++i) {
    RawFrame raw;
    try {
      raw = input.sequence->Read(i);
    } catch (const InputError& error) {
      unreadable.Add(i, {error, input.sequence->time_ns(i)});
      continue;
    }
    LightFieldFrame frame;
    {
      StageTimer::Scope scope(&frame_timer, "frame");
      frame = processor.Process(raw);
    }
    if (verdict.empty()) json["reprojection"] = ReprojectionToJson(processor, frame);
    verdict.Add(frame.sigma, processor.noise(), processor.misfit());
    writer.Write(frame);
    if (FLAGS_depth_tiff) WriteDepthTiff(i, input.camera, frame.inverse_virtual_depth);
    pinhole.Write(frame.time_ns, WithThreads(FLAGS_threads, [&] {
                    return MakePinholeView(
                        input.camera, frame, processor.dense_inverse_virtual_depth());
                  }));
    if (!FLAGS_truth.empty()) AddTruth(i, frame, &evaluator);
  }
  writer.Finish();
  pinhole.Finish();
  WriteNativeCamera((output / "camera.yaml").string(), input.camera);

  json["version"] = kVersion;
  json["git_hash"] = GitRevision();
  json["options"] = EffectiveOptions();
  json["frames"] = count;
  json["unreadable_count"] = unreadable.reasons().size();
  json["grid"] = input.grid_report;
  json["stages"] = TimesToJson(processor.timer());
  json["frame_ms"] = TimesToJson(frame_timer)["frame"];
  if (!evaluator.empty()) {
    json["accuracy"] = AccuracyToJson(evaluator);
    json["measured_fraction"] = evaluator.MeasuredFraction();
  }
  json["light_field"] = VerdictToJson(verdict);
  WriteTextAtomically((output / "lightfield.json").string(), json.dump(1) + "\n");
  std::fputs(verdict.Text().c_str(), stdout);
  std::printf("%d frames, %.0f ms a frame (median), results in %s\n",
              count,
              frame_timer.Summarize().at("frame").median_ms,
              FLAGS_output_dir.c_str());
  if (!unreadable.reasons().empty()) {
    std::printf("%zu of them could not be read and are left out\n", unreadable.reasons().size());
  }
  return verdict.IsUsable() ? kExitDone : kExitRunFailed;
}

ExitStatus Run() { return FLAGS_estimate_grid ? EstimateGridOnly() : ProcessSequence(); }

}  // namespace
}  // namespace prism

int main(int argc, char** argv) {
  return prism::RunTool(
      {"prism_lightfield",
       "turns raw plenoptic frames into virtual depth, totally focused images and pinhole views.",
       "--raw=FOLDER [--camera=FILE] [--micro_lens_grid=FILE] [--white_image=FILE] "
       "--output_dir=FOLDER\n"
       "       prism_lightfield --estimate_grid --camera=FILE [--white_image=FILE] [--raw=FOLDER] "
       "--camera_out=FILE",
       "prism_lightfield --raw=house_raw --output_dir=out/house"},
      argc,
      argv,
      prism::Run);
}
