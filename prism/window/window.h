// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "prism/camera/projection.h"
#include "prism/residual/linear_prior.h"
#include "prism/scene/keyframe.h"

namespace prism {

struct WindowOptions {
  int max_keyframes = 7;
  int max_points = 2000;             // active, over all keyframes
  int max_iterations = 3;            // of Levenberg-Marquardt, per optimisation
  double function_tolerance = 2e-3;  // relative fall of the cost below which it stops
  int threads = 2;                   // of the evaluation and the linear algebra
  PhotometricOptions photometric;
  double photometric_huber =
      3;  // standard deviations, over the norm of a pattern's 8 residuals / sqrt(8)
  double depth_huber = 1.5;    // standard deviations
  double depth_outlier = 3.5;  // standard deviations: beyond it the measurement is dropped
  // Ablations: what the paper's claims are measured against.
  bool depth_residual = true;
  bool marginalization_prior = true;
  bool first_estimate_jacobians = true;
  bool affine_brightness = true;
  bool robust_loss = true;

  bool IsValid(std::string* error) const;
};

// The state of the sliding window: keyframes (oldest first) with their points, and the
// marginalisation prior over some of them.
struct Window {
  explicit Window(const PlenopticProjection& camera) : camera(camera) {}

  PlenopticProjection camera;  // level 0
  std::deque<std::unique_ptr<Keyframe>> keyframes;
  LinearPrior prior;
  std::vector<int> prior_keyframe_ids;  // in the order of prior.linearization

  bool empty() const { return keyframes.empty(); }
  Keyframe& newest() { return *keyframes.back(); }
  const Keyframe& newest() const { return *keyframes.back(); }
  int NumPoints() const;
};

// True if the point's pattern falls into the target image at the current state, and has not been
// found to be an outlier there.
bool IsObserved(const Window& window,
                const Keyframe& host,
                const Point& point,
                const Keyframe& target);

// The same with the relative pose at hand.
bool IsObserved(const PlenopticProjection& camera,
                const SE3& target_from_host,
                const Point& point,
                const Keyframe& target);

// Fraction of the window's points that a frame at a pose measures where they are predicted to be:
// measured 1/v within three standard deviations (0.004 at the least) of the predicted one. 0 if
// fewer than 30 points meet a measurement. A wrong pose that happens to look right fails this.
double DepthAgreement(const Window& window,
                      const LightFieldFrame& frame,
                      const SE3& cam_from_world);

// Holds the gauge: a prior that ties the first keyframe's state to where it is.
void AnchorFirstKeyframe(Window* window);

}  // namespace prism
