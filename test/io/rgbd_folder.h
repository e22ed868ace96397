// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "prism/geometry/se3.h"

namespace prism {

// A folder of this test's own, empty at first.
inline std::string FreshFolder(const std::string& name) {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) /
      (std::string("prism_") + info->test_suite_name() + "_" + info->name() + "_" + name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder.string();
}

inline void WriteFile(const std::string& path, const std::string& contents) {
  std::ofstream(path) << contents;
}

// A camera that moves sideways in front of a textured, slanted plane, as a TUM RGB-D folder.
struct RgbdFolderOptions {
  int num_frames = 20;
  int width = 320;
  int height = 240;
  double focal_length_px = 262.5;
  double step = 0.02;    // m a frame
  int first_black = -1;  // frames first_black .. last_black are black
  int last_black = -1;
};

inline SE3 RgbdTruePose(const RgbdFolderOptions& options, int frame) {
  const double s = frame;
  return SE3::Exp((Vector6d() << -options.step * s,
                   0.01 * std::sin(0.4 * s),
                   0,
                   0,
                   0.004 * s,
                   0.01 * std::sin(0.3 * s))
                      .finished());
}

inline void WriteRgbdFolder(const std::string& folder, const RgbdFolderOptions& options = {}) {
  std::filesystem::create_directories(folder + "/rgb");
  std::filesystem::create_directories(folder + "/depth");
  const double f = options.focal_length_px;
  const double cx = 0.5 * options.width, cy = 0.5 * options.height;
  WriteFile(folder + "/calibration.txt",
            "# fx fy cx cy width height\n" + std::to_string(f) + " " + std::to_string(f) + " " +
                std::to_string(cx) + " " + std::to_string(cy) + " " +
                std::to_string(options.width) + " " + std::to_string(options.height) + "\n");
  std::ofstream associations(folder + "/associations.txt");
  std::ofstream groundtruth(folder + "/groundtruth.txt");
  const Eigen::Vector3d normal(-0.2, 0.1, 1);  // normal . p = 2
  for (int i = 0; i < options.num_frames; ++i) {
    const SE3 world_from_cam = RgbdTruePose(options, i).Inverse();
    cv::Mat image(options.height, options.width, CV_8UC1);
    cv::Mat depth(options.height, options.width, CV_16UC1);
    const bool is_black = i >= options.first_black && i <= options.last_black;
    for (int y = 0; y < options.height; ++y) {
      for (int x = 0; x < options.width; ++x) {
        const Eigen::Vector3d ray =
            world_from_cam.rotation() * Eigen::Vector3d((x - cx) / f, (y - cy) / f, 1);
        const double z = (2 - normal.dot(world_from_cam.translation())) / normal.dot(ray);
        const Eigen::Vector3d p = world_from_cam.translation() + z * ray;
        const double texture = 128 + 30 * std::sin(4.3 * p.x() + 1.1 * p.y()) +
                               25 * std::sin(11 * p.x() - 7 * p.y()) +
                               25 * std::sin(23 * p.x() + 3 * p.y()) * std::cos(19 * p.y()) +
                               20 * std::sin(41 * p.x() - 30 * p.y());
        image.at<uint8_t>(y, x) = is_black ? 0 : cv::saturate_cast<uint8_t>(texture);
        depth.at<uint16_t>(y, x) = is_black ? 0 : cv::saturate_cast<uint16_t>(5000 * z);
      }
    }
    char name[32], line[256];
    std::snprintf(name, sizeof(name), "%06d.png", i);
    cv::imwrite(folder + "/rgb/" + name, image);
    cv::imwrite(folder + "/depth/" + name, depth);
    std::snprintf(line, sizeof(line), "%.6f rgb/%s %.6f depth/%s\n", 0.1 * i, name, 0.1 * i, name);
    associations << line;
    const Eigen::Vector3d t = world_from_cam.translation();
    const Eigen::Quaterniond q = world_from_cam.rotation();
    std::snprintf(line,
                  sizeof(line),
                  "%.6f %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n",
                  0.1 * i,
                  t.x(),
                  t.y(),
                  t.z(),
                  q.x(),
                  q.y(),
                  q.z(),
                  q.w());
    groundtruth << line;
  }
}

}  // namespace prism
