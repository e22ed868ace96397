// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "test/fuzz/targets.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "prism/base/error.h"
#include "prism/camera/projection.h"
#include "prism/io/atomic_file.h"
#include "prism/io/camera_file.h"
#include "prism/io/focused_sequence.h"
#include "prism/io/image_file.h"
#include "prism/io/map_file.h"
#include "prism/io/micro_image_corners.h"
#include "prism/io/time_list.h"
#include "prism/io/trajectory_file.h"
#include "prism/sim/scene_file.h"
#include "tools/bench_suite.h"

namespace prism {
namespace {

// A folder of this process, in memory where there is one.
class TemporaryFolder {
 public:
  TemporaryFolder()
      : path_((IsFolder("/dev/shm") ? "/dev/shm" : "/tmp") + std::string("/prism_fuzz_") +
              std::to_string(getpid())) {
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

const std::string& Folder() {
  static const TemporaryFolder folder;
  return folder.path();
}

std::string FileOf(const std::string& bytes, const std::string& name) {
  const std::string path = InFolder(Folder(), name);
  std::ofstream(path, std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return path;
}

template <typename Read>
void Try(Read read) {
  try {
    read();
  } catch (const InputError&) {
  }
}

void ReadCameraAs(const std::string& bytes, const char* name) {
  const std::string path = FileOf(bytes, name);
  Try([&] { ReadMetricCamera(path); });
  Try([&] { ReadPinholeCamera(path); });
  Try([&] { ReadMicroLensGrid(path); });
}

void CameraYaml(const std::string& bytes) { ReadCameraAs(bytes, "camera.yaml"); }
void CameraXml(const std::string& bytes) { ReadCameraAs(bytes, "camera.xml"); }
void Pinhole(const std::string& bytes) { ReadCameraAs(bytes, "camera.txt"); }

void TimeList(const std::string& bytes) {
  const std::string path = FileOf(bytes, "list.txt");
  for (const int words : {1, 2, 3}) Try([&] { ReadTimeList(path, words); });
}

void TrajectoryText(const std::string& bytes) {
  const std::string path = FileOf(bytes, "trajectory.txt");
  for (const TrajectoryFormat format : {TrajectoryFormat::kAuto,
                                        TrajectoryFormat::kTum,
                                        TrajectoryFormat::kEuroc,
                                        TrajectoryFormat::kKitti}) {
    TrajectoryReadOptions options;
    options.format = format;
    options.kitti_rate_hz = 10;
    Try([&] { ReadTrajectory(path, options); });
  }
}

void ImageFile(const std::string& bytes) {
  const std::string path = FileOf(bytes, "image.png");
  Try([&] { ReadGrayImage(path, 8, 6); });
  Try([&] { ReadImageUnchanged(path); });
  Try([&] { ReadInverseVirtualDepth(path, 8, 6); });
}

void MapFile(const std::string& bytes) {
  PlenopticProjection camera;
  camera.width = 64;
  camera.height = 48;
  camera.b_L0 = 0.0159;
  camera.B = 0.376e-3;
  camera.f = 0.016748;
  camera.s = 1.1e-5;
  camera.c = {32, 24};
  FileOf(bytes, "map.yml");
  Try([&] { ReadMap(Folder(), camera); });
}

// Corners, a line of dashes, centres.
void MicroImageCorners(const std::string& bytes) {
  constexpr char kBorder[] = "\n---\n";
  const size_t border = std::min(bytes.find(kBorder), bytes.size());
  const size_t rest = std::min(border + sizeof(kBorder) - 1, bytes.size());
  const std::string corners = FileOf(bytes.substr(0, border), "corners.csv");
  const std::string centers = FileOf(bytes.substr(rest), "centers.csv");
  Try([&] { ReadMicroImageCorners(corners, centers); });
}

void Scene(const std::string& bytes) {
  const std::string path = FileOf(bytes, "scene.yaml");
  Try([&] { ReadSceneShape(path); });
}

void Suite(const std::string& bytes) {
  const std::string path = FileOf(bytes, "suite.yaml");
  Try([&] { ListJobs(ReadBenchSuite(path, "/data")); });
}

}  // namespace

const std::map<std::string, FuzzTarget>& FuzzTargets() {
  static const std::map<std::string, FuzzTarget> targets = {
      {"camera_xml", CameraXml},
      {"camera_yaml", CameraYaml},
      {"image", ImageFile},
      {"map", MapFile},
      {"micro_image_corners", MicroImageCorners},
      {"pinhole", Pinhole},
      {"scene", Scene},
      {"suite", Suite},
      {"time_list", TimeList},
      {"trajectory", TrajectoryText}};
  return targets;
}

}  // namespace prism
