// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/light_field_processor.h"

#include <algorithm>
#include <array>
#include <utility>

#include <opencv2/core.hpp>

#include "prism/camera/projection.h"
#include "prism/lightfield/focused_image.h"
#include "prism/lightfield/with_threads.h"

namespace prism {

bool LightFieldOptions::IsValid(std::string* error) const {
  if (pyramid_levels < 1) {
    *error = "pyramid_levels of " + std::to_string(pyramid_levels) + ", expected 1 or more";
    return false;
  }
  if (threads < 0) {
    *error = "threads of " + std::to_string(threads) + ", expected 0 (one a core) or more";
    return false;
  }
  return preparation.IsValid(error) && depth.IsValid(error);
}

LightFieldProcessor::LightFieldProcessor(const PlenopticCamera& camera,
                                         const cv::Mat& white,
                                         const LightFieldOptions& options)
    : camera_(camera),
      options_(options),
      lenses_(camera),
      preparation_(WithThreads(
          options.threads, [&] { return RawPreparation(lenses_, white, options.preparation); })),
      depth_(camera, lenses_, options.depth) {}

LightFieldFrame LightFieldProcessor::Process(const RawFrame& frame) {
  return WithThreads(options_.threads, [&] { return ProcessHere(frame); });
}

void LightFieldProcessor::Render(const ImageF& raw, ImageF* focused) const {
  RenderFocusedImage(camera_, lenses_, raw, prepared_.lens_colour, dense_, focused);
}

cv::Mat LightFieldProcessor::RenderColour(const cv::Mat& bgr) const {
  std::array<cv::Mat, 3> planes;
  ImageF channel, focused;  // one at a time: a channel of a large sensor takes 100 MB
  for (size_t c = 0; c < planes.size(); ++c) {
    preparation_.PrepareChannel(bgr, static_cast<int>(c), &channel);
    Render(channel, &focused);
    const cv::Mat plane(focused.height(), focused.width(), CV_32F, focused.data());
    plane.convertTo(planes[c], CV_8U);
  }
  cv::Mat colour;
  cv::merge(planes.data(), planes.size(), colour);
  return colour;
}

LightFieldFrame LightFieldProcessor::ProcessHere(const RawFrame& frame) {
  LightFieldFrame result;
  result.time_ns = frame.time_ns;
  result.depth_correlation_px = kMicroImageDepthCorrelation;
  {
    StageTimer::Scope scope(&timer_, "preparation");
    preparation_.Prepare(frame.image, &prepared_);
  }
  {
    StageTimer::Scope scope(&timer_, "depth");
    result.inverse_virtual_depth = ImageF(camera_.focused_width(), camera_.focused_height());
    result.sigma = ImageF(camera_.focused_width(), camera_.focused_height());
    depth_.Estimate(prepared_, &result.inverse_virtual_depth, &result.sigma);
  }
  ImageF image;
  {
    StageTimer::Scope scope(&timer_, "focused_image");
    const float far =
        static_cast<float>(std::clamp(InverseVirtualDepthAtInfinity(PlenopticProjection(camera_)),
                                      depth_.options().min_inverse_virtual_depth,
                                      depth_.options().max_inverse_virtual_depth));
    dense_depth_.Fill(result.inverse_virtual_depth, result.sigma, far, &dense_);
    Render(prepared_.gray, &image);
    const cv::Mat bgr = options_.focus_colour ? preparation_.ToBgr(frame.image) : cv::Mat();
    if (!bgr.empty()) result.colour = RenderColour(bgr);
  }
  {
    StageTimer::Scope scope(&timer_, "pyramid");
    result.image = BuildPyramid(std::move(image), options_.pyramid_levels);
  }
  return result;
}

}  // namespace prism
