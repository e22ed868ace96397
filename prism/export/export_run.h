// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "prism/camera/projection.h"
#include "prism/scene/frame.h"
#include "prism/scene/trajectory.h"

namespace prism {

// A keyframe as exports want it. Images are kept encoded (PNG): a run has hundreds.
struct ExportKeyframe {
  int id = 0;
  int64_t time_ns = 0;
  SE3 world_from_cam;
  std::vector<uint8_t> image;  // totally focused, without distortion; BGR where it is known
  std::vector<uint8_t> depth;  // 1/v and its sigma, 16 bits each, see DecodeDepth

  std::string ImageName() const;  // "000012.png", by id
};

struct ExportPoint {
  Eigen::Vector3d p_in_world = Eigen::Vector3d::Zero();  // metres
  std::array<uint8_t, 3> rgb{};
  int keyframe_id = 0;                           // its host
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // there, focused px
  double sigma_m = 0;                            // along the host's ray; 0: not known
};

// All that is exported of a run, one piece of its map.
struct ExportRun {
  PlenopticProjection camera;             // level 0
  Trajectory trajectory;                  // of all tracked frames, times of the file
  std::vector<ExportKeyframe> keyframes;  // by rising id
  std::vector<ExportPoint> points;        // each with a host among the keyframes
};

// Image and depth of a frame; sets `image` and `depth` of the keyframe. Depth is stored as in a
// focused sequence: 1/v to 1.5e-5, sigma to 1.5e-6.
void EncodeFrame(const LightFieldFrame& frame, ExportKeyframe* keyframe);

// BGR or gray as it was encoded, and gray of either.
cv::Mat DecodeImage(const ExportKeyframe& keyframe);
cv::Mat DecodeGray(const ExportKeyframe& keyframe);

struct DepthMap {
  ImageF inverse_virtual_depth;  // 1/v; 0 = no measurement
  ImageF sigma;                  // of 1/v
};
DepthMap DecodeDepth(const ExportKeyframe& keyframe);

// The pinhole camera that the totally focused image is (prism/camera/projection.h): its centre is
// the main lens or, in images of virtual points, the front focal point; its focal length f_L / s
// px. Nothing else of the plenoptic camera is left in it, and other software needs no more.
SE3 WorldFromPinhole(const PlenopticProjection& camera, const SE3& world_from_cam);

}  // namespace prism
