// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace prism {

// The one measure that residuals are weighted by and fits are judged by. Photometric residuals
// (intensities 0 to 255) scatter by the noise of both images and by what the model leaves out:
// interpolation, depth edges, reflections. Measured depths come with a standard deviation, which is
// taken times a scale.
class NoiseModel {
 public:
  // Before anything is measured. `image_sigma` of one image (EstimateImageNoise); `model_sigma` is
  // the error of the model beside it, as far as weights go.
  explicit NoiseModel(double image_sigma = 0, double model_sigma = 3.5);

  // Standard deviation that residuals of a pixel are weighted by, beside DSO's gradient weight.
  double ResidualSigma() const;
  // Times the stated standard deviation of a measured 1/v, what it is worth in the window.
  double DepthScale() const { return depth_scale_; }
  // Standard deviation of what the depths of one keyframe are off by in common, beside what all
  // keyframes share; 1/v.
  double DepthOffsetSigma() const { return depth_offset_sigma_; }
  // A posteriori variance factors of a window that fits: the two standard deviations follow them
  // slowly (variance components). Their ratio decides where translation ends up.
  void ObserveWindow(double photometric_variance_factor, double depth_variance_factor);
  // What a window tells of DepthOffsetSigma: the expected square, whose mean it follows slowly.
  // That of a window that fits badly counts as well: offsets larger than assumed are what makes it
  // so.
  void ObserveDepthOffsets(double expected_square);

  // What residuals of frames that fit really scatter by: StatedSigma() times the misfit, which is
  // the median over the last 30 frames that were told to Observe, and 1.25 at the least and before
  // (bilinear interpolation of sharp images costs that much on noise-free ones).
  double FitSigma() const { return Misfit() * StatedSigma(); }
  // The same in ResidualSigma(), the unit of weighted residuals.
  double WeightedFitSigma() const { return FitSigma() / ResidualSigma(); }
  // RMS of the residuals of a frame that fits, intensities.
  void Observe(double rms);
  // DepthAgreement of a frame that fits, and what is usual: the median of the last 5, 1 before. A
  // camera whose figures are wrong bends the map and loses agreement from frame to frame, a wrong
  // pose at once.
  void ObserveDepthAgreement(double agreement);
  double UsualDepthAgreement() const;
  // Enough frames were observed to know what fits.
  bool KnowsFit() const { return misfits_.size() >= 3; }
  // The same model with residuals taken to scatter by `factor` more than is known of them.
  NoiseModel WithWiderFit(double factor) const;

 private:
  double StatedSigma() const;  // before windows have told more
  double Misfit() const;       // in StatedSigma()

  double image_sigma_;
  double model_sigma_;
  double photometric_scale_ = 1;
  double depth_scale_ = 1;
  double depth_offset_sigma_ = 0.0002;
  double wider_fit_ = 1;
  std::vector<double> misfits_;           // of the last frames
  std::vector<double> depth_agreements_;  // of the last frames
};

}  // namespace prism
