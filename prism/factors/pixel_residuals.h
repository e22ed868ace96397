// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "prism/camera/projection.h"
#include "prism/image/image.h"

namespace prism {

// A pixel of a reference frame on one level of its pyramid.
struct ReferencePixel {
  Eigen::Vector2d m = Eigen::Vector2d::Zero();  // (x'_V - c) s / f_L: the direction of its ray
  double intensity = 0;                         // 0 to 255
  double weight = 0;                            // of its squared residual, DSO's gradient weight
};

// Pixels that are evaluated together.
inline constexpr int kPixelBatch = 64;

// Reference pixels as arrays, filled up to whole batches with places that hold no pixel.
class ReferencePixels {
 public:
  explicit ReferencePixels(size_t size = 0);

  size_t size() const { return m_x_.size(); }  // with empty places
  void Set(size_t i, const ReferencePixel& pixel);
  bool Holds(size_t i) const;
  ReferencePixel at(size_t i) const { return {{m_x_[i], m_y_[i]}, intensity_[i], weight_[i]}; }

  const double* m_x() const { return m_x_.data(); }
  const double* m_y() const { return m_y_.data(); }
  const double* intensity() const { return intensity_.data(); }
  const double* weight() const { return weight_.data(); }

 private:
  std::vector<double> m_x_, m_y_;  // NaN where there is no pixel: no frame sees it
  std::vector<double> intensity_, weight_;
};

// Where a frame stands relative to its reference, with what all pixels need of it at hand.
struct RelativeState {
  RigidMotion target_from_reference;
  double gain = 1;  // e^a: I_target = e^a I_reference + b
  double b = 0;
};

// Photometric residuals Eq. (20) of a batch of pixels, brightness relative to the reference:
//   r = I_j[Pi_pl(x_i)] - b - e^a I_i,  intensities 0 to 255.
// The tracker's form of PhotometricCost: pixels instead of patterns, no manifold to lift to.
struct PixelResiduals {
  // 1, or 0 where there is no residual: no pixel, a point at or inside the focal length, its pixel
  // not a pixel inside the image, or the image clipped there. Value and Jacobians over pose and
  // rho are then 0.
  alignas(64) double seen[kPixelBatch];
  // Rows 0 to 7: Jacobian over [target pose (left); a; b], Eqs. (29), (47), (52). Row 8: r.
  double rows[9][kPixelBatch];
  double J_rho[kPixelBatch];  // Eq. (84)

  const double* value() const { return rows[8]; }
};

// The pixels from `first` on, a whole number of batches; one inverse depth a pixel (NaN: as if
// there were no pixel). Jacobians only if asked for.
void EvaluatePixels(const ReferencePixels& pixels,
                    size_t first,
                    const double* rho,
                    const RelativeState& state,
                    const PlenopticProjection& camera,
                    const ImageViewF& target_image,
                    bool with_jacobians,
                    PixelResiduals* residuals);

}  // namespace prism
