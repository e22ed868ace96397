// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

#include "prism/base/stage_timer.h"
#include "prism/camera/plenoptic_camera.h"
#include "prism/lightfield/dense_depth.h"
#include "prism/lightfield/depth.h"
#include "prism/lightfield/lens_table.h"
#include "prism/lightfield/preparation.h"
#include "prism/scene/frame.h"

namespace prism {

struct LightFieldOptions {
  PreparationOptions preparation;
  DepthOptions depth;
  int pyramid_levels = 5;
  int threads = 0;            // see WithThreads; 0: one a core
  bool focus_colour = false;  // LightFieldFrame::colour of colour and Bayer frames as well

  bool IsValid(std::string* error) const;
};

// Turns raw frames of one camera into what the odometry works on. Tables and buffers are made once;
// a frame allocates only the images it returns and, where it is large, the rows of half-pixel
// images that are looked at. The result does not depend on the number of threads nor on the frames
// before. Not to be called from two threads at once.
class LightFieldProcessor {
 public:
  // `white`: white image of the camera's raw size, or empty for frames that are
  // vignetting-corrected. Preconditions: the camera is valid and has a micro-lens grid; the options
  // are valid; the white image is not black.
  LightFieldProcessor(const PlenopticCamera& camera,
                      const cv::Mat& white,
                      const LightFieldOptions& options);

  // Precondition: a frame of the camera's raw size, 8 or 16 bits, 1 or 3 channels.
  LightFieldFrame Process(const RawFrame& frame);

  const PlenopticCamera& camera() const { return camera_; }
  const LensTable& lenses() const { return lenses_; }
  const StageTimer& timer() const { return timer_; }

  // Of the last frame.
  const PreparedRaw& prepared() const { return prepared_; }
  const ImageF& dense_inverse_virtual_depth() const { return dense_; }
  double noise() const { return depth_.noise(); }  // of the raw image, 0 to 255
  const MatchMisfit& misfit() const { return depth_.misfit(); }

 private:
  LightFieldFrame ProcessHere(const RawFrame& frame);
  void Render(const ImageF& raw, ImageF* focused) const;
  cv::Mat RenderColour(const cv::Mat& bgr) const;

  PlenopticCamera camera_;
  LightFieldOptions options_;
  LensTable lenses_;
  RawPreparation preparation_;
  DepthEstimator depth_;
  DenseDepth dense_depth_;
  PreparedRaw prepared_;
  ImageF dense_;
  StageTimer timer_;
};

}  // namespace prism
