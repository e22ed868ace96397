// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/cost_function.h>
#include <Eigen/Core>

#include "prism/camera/projection.h"
#include "prism/factors/frame_pair.h"
#include "prism/image/image.h"
#include "prism/image/patch.h"

namespace prism {

// Photometric residual of one point between its host frame i and a target frame j, Eq. (20), in
// standard deviations:
//   r_k = weight_k / sigma ((I_j[Pi_pl(x_i + pattern_k)] - b_j) - e^(a_j - a_i) (I_i[x_i +
//   pattern_k] - b_i)).
//
// Residuals: 8. Parameter blocks: host FrameState (9), target FrameState (9), metric inverse depth
// rho_i in 1/m (1); all pixels of the pattern share rho_i. Jacobians: Eq. (29) (gradient of the
// bilinear interpolant) times Eqs. (47), (52), (84), tangent [translation; rotation] on the left,
// lifted to the 9 stored doubles; the affine ones as in errata, note 3. With first estimates in
// `pair`, everything but the image gradient is taken there.
//
// If a pixel falls outside the target image or the point is at or inside the focal length in either
// frame (at the current state or where Jacobians are evaluated), all residuals and Jacobians are
// zero.
//
// `pair` must be up to date with the two FrameStates whenever Evaluate is called. `patch`, `pair`
// and the image must outlive the cost. The projection is that of the host level.
class PhotometricCost : public ceres::CostFunction {
 public:
  PhotometricCost(const PhotometricPatch* patch,
                  const FramePair* pair,
                  const ImageViewF& target_image,
                  const PlenopticProjection* camera);

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  const PhotometricPatch* patch_;
  const FramePair* pair_;
  ImageViewF target_image_;
  const PlenopticProjection* camera_;
};

// The same residuals with the two frames held, and their derivative by rho: what a search along the
// epipolar line or for one depth needs. False where they are not defined (see above).
struct PatternMatch {
  Eigen::Matrix<double, kPatternSize, 1> residuals;
  Eigen::Matrix<double, kPatternSize, 1> J_rho;
};
bool EvaluatePattern(const PhotometricPatch& patch,
                     const FramePair& pair,
                     const ImageViewF& target_image,
                     const PlenopticProjection& camera,
                     double rho,
                     PatternMatch* match);

}  // namespace prism
