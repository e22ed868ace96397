// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "prism/camera/projection.h"
#include "prism/scene/frame.h"
#include "prism/scene/place.h"

namespace prism {

// An image of 0 to 255 in 8 bits.
cv::Mat RoundedImage(const ImageF& image);

// ORB features (E. Rublee et al., ICCV 2011) of the focused image with the depths measured at them,
// into place->features and place->descriptors.
void DetectFeatures(const PlenopticProjection& camera, const LightFieldFrame& frame, Place* place);

// Indices of features of two places that look alike, each the other's best match and clearly better
// than the second.
struct FeatureMatch {
  int query = 0;
  int known = 0;
};
std::vector<FeatureMatch> MatchFeatures(const Place& query, const Place& known);

struct FeaturePose {
  SE3 query_from_known;
  int inliers = 0;
};

// Pose of the query from the depths of the known place and the pixels of the query, by RANSAC. The
// focused image is a pinhole image (PlenopticProjection::center_z). Nothing
// if fewer than `min_inliers` matches agree.
std::optional<FeaturePose> EstimateFeaturePose(const PlenopticProjection& camera,
                                               const Place& query,
                                               const Place& known,
                                               const std::vector<FeatureMatch>& matches,
                                               int min_inliers);

}  // namespace prism
