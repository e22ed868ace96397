// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/rgbd_writer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"
#include "prism/io/focused_sequence.h"
#include "prism/io/image_file.h"

namespace prism {

RgbdWriter::RgbdWriter(const std::string& folder, const PinholeCamera& camera, double crop_fov_deg)
    : folder_(folder), camera_(camera) {
  if (crop_fov_deg > 0) camera_ = CropToFieldOfView(camera, crop_fov_deg, &left_, &top_);
  for (const char* name : {"rgb", "depth"}) {
    CreateDirectory((std::filesystem::path(folder) / name).string());
  }
}

void RgbdWriter::Write(int64_t time_ns, const PinholeFrame& frame) {
  cv::Mat gray(camera_.height, camera_.width, CV_8UC1);
  cv::Mat depth(camera_.height, camera_.width, CV_16UC1);
  for (int y = 0; y < camera_.height; ++y) {
    for (int x = 0; x < camera_.width; ++x) {
      gray.at<uint8_t>(y, x) =
          static_cast<uint8_t>(std::clamp(std::lround(frame.image(x + left_, y + top_)), 0L, 255L));
      const double value = std::round(5000.0 * frame.depth(x + left_, y + top_));
      depth.at<uint16_t>(y, x) = value <= 65535 ? static_cast<uint16_t>(value) : 0;
    }
  }
  const std::string name = FrameFileName(count_++);
  const std::filesystem::path root(folder_);
  const cv::Rect crop(left_, top_, camera_.width, camera_.height);
  WriteImage((root / "rgb" / name).string(), frame.colour.empty() ? gray : frame.colour(crop));
  WriteImage((root / "depth" / name).string(), depth);
  const std::string time = FormatTime(time_ns);
  rgb_list_ += time + " rgb/" + name + "\n";
  depth_list_ += time + " depth/" + name + "\n";
  associations_ += time + " rgb/" + name + " " + time + " depth/" + name + "\n";
}

void RgbdWriter::Finish() {
  const std::filesystem::path root(folder_);
  char calibration[160];
  std::snprintf(calibration,
                sizeof(calibration),
                "%.9g %.9g %.9g %.9g %d %d\n",
                camera_.fx,
                camera_.fy,
                camera_.cx,
                camera_.cy,
                camera_.width,
                camera_.height);
  WriteTextAtomically((root / "rgb.txt").string(), rgb_list_);
  WriteTextAtomically((root / "depth.txt").string(), depth_list_);
  WriteTextAtomically((root / "associations.txt").string(), associations_);
  WriteTextAtomically((root / "calibration.txt").string(), calibration);
}

}  // namespace prism
