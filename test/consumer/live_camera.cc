// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// Odometry on a camera while it runs. The camera here is a list of image files on standard input, a
// line the moment each is there; put your grabber in its place:
//   live_camera CAMERA.yaml WHITE_IMAGE < list
// CAMERA.yaml has the refined grid, as prism_lightfield leaves it beside its results.
#include <chrono>
#include <cstdio>
#include <iostream>
#include <string>

#include <prism/base/error.h>
#include <prism/io/camera_file.h>
#include <prism/io/raw_sequence.h>
#include <prism/lightfield/light_field_processor.h>
#include <prism/odometry/odometry.h>
#include <opencv2/imgcodecs.hpp>

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  try {
    prism::PlenopticCamera camera = prism::ReadMetricCamera(argv[1]);
    camera.focused_image = prism::FocusedImage::kChiefRays;  // the better one, as in prism_vo
    prism::LightFieldProcessor light_field(camera, prism::ReadWhiteImage(argv[2], camera), {});
    prism::Odometry odometry(camera, prism::OdometryOptions());
    for (std::string path; std::getline(std::cin, path);) {
      prism::RawFrame raw;
      raw.image = cv::imread(path, cv::IMREAD_UNCHANGED);
      raw.time_ns = std::chrono::steady_clock::now().time_since_epoch().count();
      if (raw.image.rows != camera.raw_height || raw.image.cols != camera.raw_width) continue;
      const prism::FrameResult result = odometry.Process(light_field.Process(raw));
      const Eigen::Vector3d p = result.state.pose().Inverse().translation();
      std::printf("%s %.4f %.4f %.4f\n", ToString(result.status), p.x(), p.y(), p.z());
    }
  } catch (const prism::InputError& error) {
    std::fprintf(stderr, "live_camera: %s\n", error.what());
    return 2;
  }
}
