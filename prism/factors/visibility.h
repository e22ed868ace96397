// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/scene/window.h"

namespace prism {

// True if the point has been found to be an outlier in the target.
bool IsHidden(const Point& point, const Keyframe& target);

// True if the depth the target measured there has been found to be another's.
bool IsDepthOutlier(const Point& point, const Keyframe& target);

// True if the point's pattern falls into the target image and has not been found to be an outlier
// there. Then `x_V` is where (ProjectBetweenFrames).
bool IsObserved(const PlenopticProjection& camera,
                const RigidMotion& target_from_host,
                const Point& point,
                const Keyframe& target,
                Eigen::Vector3d* x_V);
bool IsObserved(const PlenopticProjection& camera,
                const RigidMotion& target_from_host,
                const Point& point,
                const Keyframe& target);

// The same at the current states.
bool IsObserved(const Window& window,
                const Keyframe& host,
                const Point& point,
                const Keyframe& target);

}  // namespace prism
