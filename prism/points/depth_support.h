// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/camera/projection.h"
#include "prism/scene/frame.h"

namespace prism {

// Whether a point can be given the depth measured at a pixel, as far as the frame itself can tell.
// What is passed must outlive it.
class DepthSupport {
 public:
  DepthSupport(const PlenopticProjection& camera, const LightFieldFrame& frame);

  // False if most of the depths measured around a pixel contradict its own. At the edge of a thing
  // half of them do.
  bool IsSupported(int x, int y) const;

  // True if something nearer begins within reach of a point's pattern: its outline, which moves as
  // it does, is then what the pattern sees, not the surface behind, whose depth is measured.
  // Distances and the path come out too long by such points (docs/depth.md).
  bool IsBesideNearer(int x, int y);

 private:
  // Of the depths measured in the 3 x 3 pixels around one: their median, and the variance of their
  // mean; negative where there are none.
  struct LocalDepth {
    float w = 0;
    float variance = 0;  // 0: not looked at yet
  };
  const LocalDepth& DepthAround(int x, int y);

  const LightFieldFrame& frame_;
  const float towards_camera_;  // sign of a change of 1/v
  Image<LocalDepth> local_;
};

}  // namespace prism
