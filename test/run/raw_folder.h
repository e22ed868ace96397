// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <string>

#include <opencv2/imgcodecs.hpp>

#include "prism/io/camera_file.h"
#include "test/io/rgbd_folder.h"
#include "test/lightfield/synthetic_frame.h"

namespace prism {

// Raw frames of a textured plane with a white image and camera.yaml. The plane comes nearer from
// frame to frame; times are 0, 0.1, 0.2 ... s.
inline void WriteRawFolder(const std::string& folder,
                           int num_frames,
                           const PlenopticCamera& camera = SmallCamera()) {
  std::ofstream list(folder + "/raw.txt");
  for (int i = 0; i < num_frames; ++i) {
    const std::string name = std::to_string(i) + ".png";
    cv::imwrite(folder + "/" + name, RenderPlane(camera, 0.25 + 0.02 * i, WavyTexture, 1, true));
    list << 0.1 * i << " " << name << "\n";
  }
  cv::imwrite(folder + "/white.png",
              RenderPlane(
                  camera, 0.3, [](double, double) { return 200; }, 1, true));
  WriteNativeCamera(folder + "/camera.yaml", camera);
}

}  // namespace prism
