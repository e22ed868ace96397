// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/run/folder_contents.h"

#include <filesystem>
#include <variant>

#include "prism/base/error.h"
#include "prism/io/camera_file.h"
#include "prism/io/frame_files.h"

namespace prism {
namespace {

std::string FindCamera(const std::string& folder) {
  for (const char* name : {"camera.yaml", "camera.yml", "CameraModel.xml"}) {
    std::string path = FindFile(folder, name);
    if (!path.empty() && std::holds_alternative<PlenopticCamera>(ReadCamera(path))) return path;
  }
  return "";
}

std::string NameOf(const std::string& path) {
  return std::filesystem::path(path).filename().string() + " of the folder";
}

}  // namespace

SequenceOptions CompleteFromFolder(const SequenceOptions& options,
                                   const std::string& format,
                                   std::vector<std::string>* report) {
  SequenceOptions complete = options;
  if (options.camera.empty()) {
    complete.camera = FindCamera(options.sequence);
    if (!complete.camera.empty()) {
      report->push_back("camera: " + NameOf(complete.camera));
    } else if (format == "rgbd") {
      report->push_back(
          "camera: assumed to stand in for a Raytrix R5 with a 16 mm lens (--camera)");
    } else {
      throw InputError(options.sequence,
                       "neither camera.yaml nor CameraModel.xml",
                       "a camera file there or by --camera");
    }
  } else {
    report->push_back("camera: " + options.camera);
  }
  if (format != "raw") return complete;
  if (!options.micro_lens_grid.empty()) {
    report->push_back("micro-lens grid: " + options.micro_lens_grid);
  } else if (ReadPlenopticCamera(complete.camera).micro_lens_grid) {
    report->push_back("micro-lens grid: that of the camera file");
  } else {
    complete.micro_lens_grid = FindFile(options.sequence, "MLA_Calibration.xml");
    if (!complete.micro_lens_grid.empty()) {
      report->push_back("micro-lens grid: " + NameOf(complete.micro_lens_grid));
    }
  }
  return complete;
}

PlenopticCamera StandInCamera() {
  PlenopticCamera camera;
  camera.focal_length = 16.748e-3;
  camera.main_lens_mla_distance = 15.893e-3;
  camera.sensor_mla_distance = 0.376e-3;
  camera.raw_width = camera.raw_height = 2048;
  camera.raw_pixel_size = 0.0055e-3;
  camera.raw_principal_point = {1018.7, 1054.2};
  return camera;
}

}  // namespace prism
