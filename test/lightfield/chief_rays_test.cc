// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/chief_rays.h"

#include <cmath>

#include <gtest/gtest.h>

#include "prism/image/pyramid.h"
#include "prism/lightfield/focused_image.h"
#include "prism/lightfield/lens_table.h"
#include "prism/lightfield/preparation.h"
#include "test/lightfield/synthetic_frame.h"

namespace prism {
namespace {

constexpr float kTrue = 0.3f, kTaken = 0.33f;  // 1/v of a plane, and what is measured of it

PlenopticCamera Camera(FocusedImage image) {
  PlenopticCamera camera = SmallCamera();
  camera.raw_principal_point = {-180, 430};  // off the image: it is displaced by many px
  camera.focused_image = image;
  return camera;
}

ImageF RenderWithTakenDepth(FocusedImage image) {
  const PlenopticCamera camera = Camera(image);
  const LensTable lenses(camera);
  RawPreparation preparation(lenses, {}, {});
  PreparedRaw prepared;
  preparation.Prepare(RenderPlane(camera, kTrue, WavyTexture), &prepared);
  ImageF result;
  RenderFocusedImage(camera,
                     lenses,
                     prepared.gray,
                     prepared.lens_colour,
                     ImageF(camera.focused_width(), camera.focused_height(), kTaken),
                     &result);
  return result;
}

// The plane is measured in every third pixel.
LightFieldFrame MeasuredFrame(ImageF image) {
  LightFieldFrame frame;
  frame.time_ns = 7;
  frame.inverse_virtual_depth = frame.sigma = ImageF(image.width(), image.height(), 0);
  for (size_t i = 0; i < image.size(); i += 3) {
    frame.inverse_virtual_depth.data()[i] = kTaken;
    frame.sigma.data()[i] = 0.01f;
  }
  frame.image = BuildPyramid(std::move(image), 3);
  return frame;
}

double MeanDifference(const ImageF& a, const ImageF& b) {
  double sum = 0;
  for (int y = 30; y < 130; ++y) {
    for (int x = 30; x < 130; ++x) sum += std::abs(a(x, y) - b(x, y));
  }
  return sum / 10000;
}

TEST(ChiefRays, OfAFrameRenderedWithWrongDepthAreThoseOfTheRawImage) {
  const ImageF chief_rays = RenderWithTakenDepth(FocusedImage::kChiefRays);
  const LightFieldFrame frame = MeasuredFrame(RenderWithTakenDepth(FocusedImage::kVirtualPoints));
  const LightFieldFrame turned = ToChiefRays(Camera(FocusedImage::kVirtualPoints), frame);
  EXPECT_GT(MeanDifference(frame.image[0], chief_rays), 8);
  EXPECT_LT(MeanDifference(turned.image[0], chief_rays), 1.5);
  EXPECT_EQ(turned.image.size(), 3u);
  EXPECT_EQ(turned.time_ns, 7);
  int measured = 0;
  for (size_t i = 0; i < turned.sigma.size(); ++i) {
    if (turned.sigma.data()[i] == 0) continue;
    ASSERT_EQ(turned.inverse_virtual_depth.data()[i], kTaken);
    ++measured;
  }
  EXPECT_GT(measured, 0.25 * static_cast<double>(turned.sigma.size()));
}

TEST(ChiefRays, OfAFrameWithoutDepthAreThoseOfWhatIsInfinitelyFar) {
  const PlenopticCamera camera = Camera(FocusedImage::kVirtualPoints);
  LightFieldFrame frame = MeasuredFrame(RenderWithTakenDepth(FocusedImage::kVirtualPoints));
  frame.sigma = frame.inverse_virtual_depth = ImageF(frame.sigma.width(), frame.sigma.height(), 0);
  const LightFieldFrame turned = ToChiefRays(camera, frame);
  // b_L = f_L: all stays where it is.
  EXPECT_LT(MeanDifference(turned.image[0], frame.image[0]), 0.1);
}

}  // namespace
}  // namespace prism
