// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// Renders raw sequences of a focused plenoptic camera with ground truth.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <sstream>

#include <gflags/gflags.h>
#include <tbb/global_control.h>

#include "prism/base/error.h"
#include "prism/io/camera_file.h"
#include "prism/io/trajectory_file.h"
#include "prism/sim/board_views.h"
#include "prism/sim/scene_file.h"
#include "prism/sim/simulate_sequence.h"
#include "tools/tool_main.h"

DEFINE_string(scene, "room", "Built-in scene (room, facade, plane, board) or a YAML file");
DEFINE_string(camera, "", "Plenoptic camera with a micro-lens grid (calib/*.yaml)");
DEFINE_string(micro_lens_grid, "", "Raytrix grid file, for a camera file without a grid");
DEFINE_string(
    trajectory,
    "loop",
    "handheld, loop, rotation, forward, shake, views (still pictures of the board), or a TUM "
    "file (world_from_cam, z up)");
DEFINE_string(output_dir, "", "Folder of the sequence; made if absent, completed if not");
DEFINE_int32(frames, 60, "Frames of a generated trajectory");
DEFINE_double(rate_hz, 15, "Frames a second of a generated trajectory");
DEFINE_double(extent_m, 0, "Size of a generated motion in m; 0: the scene's own");
DEFINE_double(max_tilt_deg, 40, "Of --trajectory=views: largest tilt of the board");
DEFINE_int32(crop_px, 0, "Side of a square cut from the middle of the sensor, raw px; 0: all");
DEFINE_int32(samples, 4, "Rays a raw pixel");
DEFINE_uint64(seed, 1, "Of samples, noise and generated motion");
DEFINE_double(micro_lens_aperture, 0.9, "Micro-lens diameter in pitches; 0: pinholes, no defocus");
DEFINE_double(main_lens_aperture, 1, "Main-lens diameter; 1: micro images as wide as the pitch");
DEFINE_string(colour, "gray", "gray, colour (BGR) or bayer_rggb");
DEFINE_int32(bits, 8, "Bits a raw value, 8 to 16");
DEFINE_double(full_well, 8000, "Electrons at full scale (shot noise); 0: no noise");
DEFINE_double(read_noise, 8, "Electrons, standard deviation");
DEFINE_double(exposure_ms, 4, "Exposure time in ms (motion blur)");
DEFINE_double(exposure_change, 0.08, "Relative amplitude of a slow change of brightness");
DEFINE_int32(truth_every, 10, "Depth truth of every Nth frame; 0: none");
DEFINE_bool(preview, false, "Also write what a conventional camera would see");
DEFINE_bool(replace, false, "Remove frames in the folder that were rendered with other flags");
DEFINE_int32(threads, 0, "Threads; 0: one a core");

namespace prism {
namespace {

SensorColour ReadColour() {
  if (FLAGS_colour == "gray") return SensorColour::kGray;
  if (FLAGS_colour == "colour") return SensorColour::kColour;
  if (FLAGS_colour == "bayer_rggb") return SensorColour::kBayerRggb;
  throw InputError("--colour", "'" + FLAGS_colour + "'", "gray, colour or bayer_rggb");
}

template <typename T>
void RequireValid(const T& options) {
  std::string error;
  if (options.IsValid(&error)) return;
  const size_t split = error.find(", expected ");
  throw InputError("flags", error.substr(0, split), error.substr(split + 11));
}

SimulateOptions ReadOptions() {
  SimulateOptions options;
  options.optics.micro_lens_aperture = FLAGS_micro_lens_aperture;
  options.optics.main_lens_aperture = FLAGS_main_lens_aperture;
  options.render.samples = FLAGS_samples;
  options.render.seed = FLAGS_seed;
  options.sensor.colour = ReadColour();
  options.sensor.bits = FLAGS_bits;
  options.sensor.full_well_electrons = FLAGS_full_well;
  options.sensor.read_noise_electrons = FLAGS_read_noise;
  options.sensor.seed = FLAGS_seed;
  options.exposure_s = 1e-3 * FLAGS_exposure_ms;
  options.exposure_change = FLAGS_exposure_change;
  options.truth_every = FLAGS_truth_every;
  options.preview = FLAGS_preview;
  options.replace = FLAGS_replace;
  RequireValid(options);
  return options;
}

// The camera of the middle crop_px x crop_px of the sensor: the same lenses, fewer pixels.
PlenopticCamera Crop(PlenopticCamera camera, int side) {
  const int dx = (camera.raw_width - side) / 2;
  const int dy = (camera.raw_height - side) / 2;
  if (side < 32 || dx < 0 || dy < 0 || side % camera.focused_scale != 0) {
    throw InputError("--crop_px",
                     std::to_string(side),
                     "a multiple of the focused scale from 32 to the sensor's side");
  }
  // The grid counts from the image centre: it moves with the half pixel that rounding leaves.
  camera.micro_lens_grid->offset_px +=
      Eigen::Vector2d(0.5 * (camera.raw_width - side) - dx, dy - 0.5 * (camera.raw_height - side));
  camera.raw_principal_point -= Eigen::Vector2d(dx, dy);
  camera.raw_width = side;
  camera.raw_height = side;
  return camera;
}

PlenopticCamera ReadSimulatedCamera() {
  RequireFlag("camera", FLAGS_camera, "a plenoptic camera, such as calib/raytrix_r5_16mm.yaml");
  PlenopticCamera camera = ReadPlenopticCamera(FLAGS_camera);
  if (!FLAGS_micro_lens_grid.empty()) {
    AddMicroLensGrid(FLAGS_micro_lens_grid, &camera);
  }
  RequireMetricDepth(camera, FLAGS_camera);
  if (!camera.micro_lens_grid) {
    throw InputError(FLAGS_camera, "no micro_lens_grid", "one, or --micro_lens_grid=FILE");
  }
  return FLAGS_crop_px == 0 ? camera : Crop(camera, FLAGS_crop_px);
}

CameraMotion ReadMotion(const PlenopticCamera& camera, SimPath path) {
  if (!(FLAGS_extent_m >= 0 && FLAGS_extent_m < 1e6)) {
    throw InputError("--extent_m", std::to_string(FLAGS_extent_m), "a size in m, or 0");
  }
  if (FLAGS_extent_m > 0) path.extent = FLAGS_extent_m;
  if (FLAGS_trajectory == "views") {
    BoardViewOptions options;
    options.num_views = FLAGS_frames;
    options.rate_hz = FLAGS_rate_hz;
    options.seed = FLAGS_seed;
    options.max_tilt_deg = FLAGS_max_tilt_deg;
    RequireValid(options);
    return GenerateBoardViews(options, camera, path);
  }
  MotionOptions options;
  if (!ParseMotionKind(FLAGS_trajectory, &options.kind)) {
    if (!std::filesystem::exists(FLAGS_trajectory)) {
      throw InputError("--trajectory",
                       "'" + FLAGS_trajectory + "'",
                       "handheld, loop, rotation, forward, shake, views or a file");
    }
    return FollowTrajectory(ReadTrajectory(FLAGS_trajectory));
  }
  options.num_frames = FLAGS_frames;
  options.rate_hz = FLAGS_rate_hz;
  options.seed = FLAGS_seed;
  RequireValid(options);
  return GenerateMotion(options, path);
}

// Everything that determines the pictures, a line a flag.
std::string Description() {
  std::ostringstream text;
  for (const auto& [name, value] : EffectiveOptions()) {
    if (name != "output_dir" && name != "replace" && name != "threads")
      text << "--" << name << "=" << value << "\n";
  }
  return text.str();
}

void PrintProgress(const SimulateProgress& progress) {
  std::printf(
      "frame %d / %d  %s\n",
      progress.frame,
      progress.num_frames,
      progress.reused ? "kept" : (std::to_string(progress.seconds).substr(0, 5) + " s").c_str());
  std::fflush(stdout);
}

ExitStatus Run() {
  RequireFlag("output_dir", FLAGS_output_dir, "a folder for the sequence");
  if (FLAGS_threads < 0 || FLAGS_threads > 1024) {
    throw InputError("--threads", std::to_string(FLAGS_threads), "0 (one a core) to 1024");
  }
  std::unique_ptr<tbb::global_control> threads;
  if (FLAGS_threads > 0) {
    threads = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                    FLAGS_threads);
  }
  const SimulateOptions options = ReadOptions();
  const PlenopticCamera camera = ReadSimulatedCamera();
  const SimScene scene = ReadScene(FLAGS_scene);
  const CameraMotion motion = ReadMotion(camera, scene.path);
  SimulateSequence(scene,
                   camera,
                   motion,
                   FLAGS_trajectory,
                   options,
                   Description(),
                   FLAGS_output_dir,
                   PrintProgress);
  std::cout << "sequence: " << FLAGS_output_dir << std::endl;
  return kExitDone;
}

}  // namespace
}  // namespace prism

int main(int argc, char** argv) {
  return prism::RunTool({"prism_simulate",
                         "renders a raw sequence of a focused plenoptic camera with ground truth.",
                         "--camera=FILE --output_dir=FOLDER [--scene=] [--trajectory=]",
                         "prism_simulate --camera=calib/raytrix_r5_16mm.yaml --frames=30 "
                         "--output_dir=out/room"},
                        argc,
                        argv,
                        prism::Run);
}
