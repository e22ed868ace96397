// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/simulate_sequence.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <sstream>
#include <vector>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"
#include "prism/io/camera_file.h"
#include "prism/io/image_file.h"
#include "prism/io/trajectory_file.h"

namespace prism {
namespace {

namespace fs = std::filesystem;

constexpr int kExposureMoments = 32;   // poses over the exposure
constexpr double kBrightLevel = 0.92;  // of full scale, of the brightest percent
constexpr double kFar = 1e6;           // m

// To be raised with every change of the pixels, so that old frames and new ones are not mixed.
constexpr char kRenderer[] = "renderer 2\n";

std::string FrameName(const std::string& folder, size_t frame, const char* extension) {
  char name[32];
  std::snprintf(name, sizeof(name), "/%06zu", frame);
  return folder + name + extension;
}

// What the folder holds already must have been rendered by the same description; else it is an
// error, or is removed.
void ClaimFolder(const std::string& folder, const std::string& description, bool replace) {
  const std::string path = folder + "/simulate.txt";
  const std::string found = fs::exists(path) ? ReadTextFile(path) : "";
  if (found == description) return;
  if (found.empty() || replace) {
    for (const char* name :
         {"/raw.txt", "/raw", "/white.png", "/virtual_depth_truth", "/depth_truth", "/preview"}) {
      if (!found.empty()) fs::remove_all(folder + name);
    }
    CreateDirectory(folder);
    WriteTextAtomically(path, description);
    return;
  }
  std::istringstream old_lines(found);
  std::istringstream new_lines(description);
  std::string old_line;
  std::string new_line;
  while (std::getline(new_lines, new_line) && std::getline(old_lines, old_line)) {
    if (old_line != new_line) break;
  }
  throw InputError(path,
                   "frames rendered with '" + old_line + "'",
                   "'" + new_line + "', another --output_dir, or --replace");
}

void RequireFreeSpace(const RayCaster& caster,
                      const Trajectory& poses,
                      double clearance,
                      const std::string& motion_name) {
  for (size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Vector3d p = poses[i].world_from_cam.translation();
    std::ostringstream found;
    if (p.cwiseAbs().maxCoeff() > kFar) {
      throw InputError(
          motion_name, "frame " + std::to_string(i) + " out of sight", "poses within 1000 km");
    }
    if (caster.IsInside(p)) {
      found << "frame " << i << " at (" << p.transpose() << ") m inside an object";
    } else if (caster.Clearance(p) < clearance) {
      found << "frame " << i << " at (" << p.transpose() << ") m touching a surface";
    } else {
      continue;
    }
    throw InputError(motion_name, found.str(), "a camera in free space");
  }
}

// Gain that puts the 99th percentile of what is seen along the way at kBrightLevel.
double Gain(const RayCaster& caster,
            const PlenopticCamera& camera,
            const Trajectory& poses,
            const RenderOptions& options) {
  std::vector<float> values;
  const int reduction = std::max(1, camera.focused_width() / 64);
  const size_t step = std::max<size_t>(1, poses.size() / 8);
  for (size_t i = 0; i < poses.size(); i += step) {
    const cv::Mat view = RenderPreview(caster, camera, poses[i].world_from_cam, options, reduction);
    for (int y = 0; y < view.rows; ++y) {
      for (int x = 0; x < view.cols; ++x) {
        const cv::Vec3f& bgr = view.at<cv::Vec3f>(y, x);
        values.push_back(std::max({bgr[0], bgr[1], bgr[2]}));
      }
    }
  }
  const auto bright = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 99 / 100);
  std::nth_element(values.begin(), bright, values.end());
  return *bright > 0 ? kBrightLevel / *bright : 1.0;
}

std::vector<SE3> ExposurePoses(const CameraMotion& motion, int64_t time_ns, double exposure_s) {
  const double middle = 1e-9 * static_cast<double>(time_ns);
  if (exposure_s == 0) return {motion.world_from_cam(middle)};
  std::vector<SE3> poses;
  for (int i = 0; i < kExposureMoments; ++i) {
    poses.push_back(
        motion.world_from_cam(middle + exposure_s * ((i + 0.5) / kExposureMoments - 0.5)));
  }
  return poses;
}

void WriteTruth(const DepthTruth& truth, const std::string& folder, size_t frame) {
  const int width = truth.depth.width();
  const int height = truth.depth.height();
  cv::Mat encoded(height, width, CV_16U, cv::Scalar(0));
  cv::Mat depth(height, width, CV_32F, cv::Scalar(0));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      depth.at<float>(y, x) = truth.depth(x, y);
      const double w = truth.inverse_virtual_depth(x, y);
      if (w > 0 && w <= 0.5) {
        encoded.at<uint16_t>(y, x) = static_cast<uint16_t>(std::lround((1 - w) * 65535));
      }
    }
  }
  WriteImage(FrameName(folder + "/depth_truth", frame, ".tiff"), depth);
  WriteImage(FrameName(folder + "/virtual_depth_truth", frame, ".png"), encoded);
}

void WriteCamera(const PlenopticCamera& camera, const std::string& folder) {
  WriteNativeCamera(folder + "/camera.yaml", camera);
  if (camera.focused_scale == 2) WriteLifcalCamera(folder + "/CameraModel.xml", camera);
  WriteRaytrixGrid(folder + "/MLA_Calibration.xml", *camera.micro_lens_grid);
}

std::string RawList(const Trajectory& poses) {
  std::ostringstream list;
  list << "# time path\n";
  for (size_t i = 0; i < poses.size(); ++i) {
    char time[32];
    std::snprintf(time, sizeof(time), "%.9f ", 1e-9 * static_cast<double>(poses[i].time_ns));
    list << time << FrameName("raw", i, ".png") << "\n";
  }
  return list.str();
}

}  // namespace

bool SimulateOptions::IsValid(std::string* error) const {
  if (!optics.IsValid(error) || !render.IsValid(error) || !sensor.IsValid(error)) return false;
  if (!(exposure_s >= 0 && exposure_s <= 1)) {
    *error = "an exposure of " + std::to_string(exposure_s) + " s, expected 0 to 1 s";
  } else if (!(exposure_change >= 0 && exposure_change < 1)) {
    *error = "an exposure change of " + std::to_string(exposure_change) + ", expected 0 to below 1";
  } else if (truth_every < 0) {
    *error = "truth every " + std::to_string(truth_every) + " frames, expected 0 (none) or more";
  } else {
    return true;
  }
  return false;
}

void SimulateSequence(const SimScene& scene,
                      const PlenopticCamera& camera,
                      const CameraMotion& motion,
                      const std::string& motion_name,
                      const SimulateOptions& options,
                      const std::string& description,
                      const std::string& output_dir,
                      const std::function<void(const SimulateProgress&)>& on_frame) {
  const RayCaster caster(scene);
  const PlenopticOptics optics(camera, options.optics);
  const Trajectory poses = motion.AtFrames();
  RequireFreeSpace(caster, poses, 2 * camera.focal_length, motion_name);

  ClaimFolder(output_dir, kRenderer + description, options.replace);
  CreateDirectory(output_dir + "/raw");
  if (options.truth_every > 0) {
    CreateDirectory(output_dir + "/virtual_depth_truth");
    CreateDirectory(output_dir + "/depth_truth");
  }
  if (options.preview) CreateDirectory(output_dir + "/preview");
  WriteCamera(camera, output_dir);
  WriteTrajectory(output_dir + "/groundtruth.txt", poses);
  const cv::Mat white = RenderWhite(optics);
  if (!fs::exists(output_dir + "/white.png")) {
    SensorOptions noiseless = options.sensor;
    noiseless.full_well_electrons = 0;
    WriteImage(output_dir + "/white.png", ReadSensor(white, kBrightLevel, noiseless, 0));
  }

  const double gain = Gain(caster, camera, poses, options.render);
  for (size_t i = 0; i < poses.size(); ++i) {
    const auto start = std::chrono::steady_clock::now();
    SimulateProgress progress;
    progress.frame = static_cast<int>(i) + 1;
    progress.num_frames = static_cast<int>(poses.size());
    const std::string raw_path = FrameName(output_dir + "/raw", i, ".png");
    progress.reused = fs::exists(raw_path);
    if (!progress.reused) {
      const bool has_truth = options.truth_every > 0 && i % options.truth_every == 0;
      if (has_truth) {
        WriteTruth(RenderDepthTruth(caster, camera, poses[i].world_from_cam), output_dir, i);
      }
      // The change of brightness has one period over the sequence.
      const double phase = 2 * M_PI * static_cast<double>(i) / static_cast<double>(poses.size());
      const double frame_gain = gain * (1 + options.exposure_change * std::sin(phase));
      if (options.preview) {
        SensorOptions colour = options.sensor;
        colour.colour = SensorColour::kColour;
        const cv::Mat view = RenderPreview(caster, camera, poses[i].world_from_cam, options.render);
        WriteImage(FrameName(output_dir + "/preview", i, ".png"),
                   ReadSensor(view, frame_gain, colour, i));
      }
      const auto exposure = ExposurePoses(motion, poses[i].time_ns, options.exposure_s);
      const cv::Mat raw = RenderRaw(caster, optics, white, exposure, options.render, i);
      WriteImage(raw_path, ReadSensor(raw, frame_gain, options.sensor, i));
    }
    progress.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    on_frame(progress);
  }
  WriteTextAtomically(output_dir + "/raw.txt", RawList(poses));
}

}  // namespace prism
