// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "prism/image/image.h"
#include "prism/image/patch.h"

namespace prism {

// The pixels of a pattern side by side, for PhotometricCost: numbers without Eigen, for vector
// instructions.

// X = rho x_C of a pattern's pixels in the target frame, affine in the pixel:
// X(dx, dy) = center + dx step_x + dy step_y.
struct PatternGeometry {
  const double *center, *step_x, *step_y;  // 3 each
  double rho = 0;
  double center_z = 0, f_px = 0, c_x = 0, c_y = 0;  // of the camera, see ScaledProjection
};

// Residual k is weight[k] (I_target - target_b) - weight[k] gain (I_host - host_b).
struct PatternBrightness {
  const float *intensity, *weight;  // kPatternSize each, of the host
  double inverse_sigma = 1, gain = 1, host_b = 0, target_b = 0;
};

struct PatternSamples {
  alignas(64) double weight[kPatternSize];  // of each residual over its standard deviation
  double gradient_x[kPatternSize], gradient_y[kPatternSize];  // Eq. (29), weighted
  double brightness[kPatternSize];                            // weight gain (I_host - host_b)
  double residuals[kPatternSize];
};

// False if a pixel lies at or inside the focal length or outside the image.
bool SamplePattern(const PatternGeometry& geometry,
                   const PatternBrightness& brightness,
                   const ImageViewF& target_image,
                   PatternSamples* samples);

// Derivatives of the residuals over the target pose (Eqs. (47), (52), a row for each of
// [translation; rotation]) and over rho (Eq. (84)).
struct PatternDerivatives {
  alignas(64) double pose[6][kPatternSize];
  double rho[kPatternSize];
};

// `d_geometry`: of center and steps over rho.
void DifferentiatePattern(const PatternGeometry& geometry,
                          const PatternGeometry& d_geometry,
                          const PatternSamples& samples,
                          PatternDerivatives* derivatives);

// The derivatives over the host's pose: -J_pose adjoint (6 x 6, column-major).
void MovePattern(const PatternDerivatives& target, const double* adjoint, PatternDerivatives* host);

// Jacobian over the 9 numbers of a FrameState (8 x 9, row-major), that over the pose lifted by the
// 6 x 7 matrix [L, I; M, 0] (row-major).
void LiftPattern(const PatternDerivatives& derivatives,
                 const double* lift,
                 const double* J_a,
                 const double* J_b,
                 double* jacobian);

}  // namespace prism
