// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "prism/image/interpolation.h"
#include "prism/tracking/frame_alignment.h"
#include "prism/tracking/keyframe_decision.h"
#include "prism/tracking/tracker.h"
#include "test/window/synthetic_window.h"

namespace prism {
namespace {

constexpr int64_t kFrame_ns = 50'000'000;

SyntheticOptions SmallImages() {
  SyntheticOptions options;
  options.width = 320;
  options.height = 240;
  return options;
}

// A reference at the origin with true depths on a grid of points, and frames rendered anywhere.
class PlaneScene {
 public:
  explicit PlaneScene(Texture texture = PlaneTexture)
      : model_(SyntheticCamera(SmallImages())), camera_(model_), texture_(std::move(texture)) {
    reference_image_ = Render(SE3());
    for (int y = 12; y < camera_.height - 12; y += 8) {
      for (int x = 12; x < camera_.width - 12; x += 8) {
        Eigen::Vector3d p;
        points_.push_back(
            {Eigen::Vector2d(x, y), 1 / PlaneDepth(camera_, SE3(), Eigen::Vector2d(x, y), &p), 0});
      }
    }
  }

  ImagePyramid Render(const SE3& cam_from_world) const {
    return RenderPlane(camera_, cam_from_world, 0, nullptr, texture_)->image;
  }
  TrackingReference Reference() const { return Reference(points_); }
  TrackingReference Reference(const std::vector<ReferencePoint>& points) const {
    return MakeTrackingReference(model_, reference_image_, points);
  }
  const std::vector<ReferencePoint>& points() const { return points_; }
  const ImagePyramid& reference_image() const { return reference_image_; }

 private:
  PlenopticCamera model_;
  PlenopticProjection camera_;
  Texture texture_;
  ImagePyramid reference_image_;
  std::vector<ReferencePoint> points_;
};

Vector6d AxisMotion(int axis, double size) {
  Vector6d tangent = Vector6d::Zero();
  tangent(axis) = size;
  return tangent;
}

TEST(AlignFrame, ComesBackFromAPerturbationAlongEachAxis) {
  const PlaneScene scene;
  const TrackingReference reference = scene.Reference();
  for (int axis = 0; axis < 6; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      const SE3 truth = SE3::Exp(AxisMotion(axis, sign * (axis < 3 ? 0.05 : 0.03)));
      const FrameAlignmentResult result =
          AlignFrame(reference, scene.Render(truth), {}, NoiseModel(), {});
      EXPECT_EQ(result.status, AlignmentStatus::kGood) << "axis " << axis;
      EXPECT_LT((result.state.target_from_reference * truth.Inverse()).Log().norm(), 1e-3)
          << "axis " << axis << ", sign " << sign;
    }
  }
}

// The depths of single frames: wrong by 10 % (one standard deviation), each point for itself.
TEST(AlignFrame, UncertainDepthsDoNotTurnTranslationIntoRotation) {
  const PlaneScene scene;
  const SE3 truth = SE3::Exp((Vector6d() << 0.03, 0, 0, 0, 0, 0).finished());
  const ImagePyramid target = scene.Render(truth);
  double rotation[2] = {0, 0}, translation[2] = {0, 0};
  constexpr int kSeeds = 10;
  for (int seed = 0; seed < kSeeds; ++seed) {
    std::mt19937_64 generator = SeededGenerator(33, seed);
    std::normal_distribution<double> normal;
    std::vector<ReferencePoint> points = scene.points();
    for (ReferencePoint& point : points) {
      point.rho_sigma = 0.1 * point.rho;
      point.rho += point.rho_sigma * normal(generator);
    }
    const TrackingReference reference = scene.Reference(points);
    for (const bool free_depths : {false, true}) {
      AlignmentOptions options;
      if (!free_depths) options.free_depth_levels = 0;
      const FrameAlignmentResult result = AlignFrame(reference, target, {}, NoiseModel(), options);
      ASSERT_EQ(result.status, AlignmentStatus::kGood);
      const Vector6d error = (result.state.target_from_reference * truth.Inverse()).Log();
      translation[free_depths] += error.head<3>().norm() / kSeeds;
      rotation[free_depths] += error.tail<3>().norm() / kSeeds;
    }
  }
  EXPECT_LT(translation[1], 0.7 * translation[0]) << "held: " << translation[0];
  EXPECT_LT(rotation[1], 0.7 * rotation[0]) << "held: " << rotation[0];
  EXPECT_LT(translation[1], 0.003) << "of 0.03";
}

TEST(AlignFrame, EstimatesAChangeOfBrightness) {
  const PlaneScene scene;
  ImageF changed = scene.reference_image()[0];
  for (size_t i = 0; i < changed.size(); ++i) changed.data()[i] = 0.8f * changed.data()[i] + 12;
  const FrameAlignmentResult result =
      AlignFrame(scene.Reference(), BuildPyramid(changed, 6), {}, NoiseModel(), {});
  EXPECT_EQ(result.status, AlignmentStatus::kGood);
  EXPECT_NEAR(result.state.a, std::log(0.8), 0.01);
  EXPECT_NEAR(result.state.b, 12, 1);
  EXPECT_LT(result.state.target_from_reference.Log().norm(), 1e-4);
}

TEST(AlignFrame, MeasuresTheFlow) {
  const PlaneScene scene;
  const SE3 rotation = SE3::Exp(AxisMotion(4, 0.03));
  const FrameAlignmentResult result =
      AlignFrame(scene.Reference(), scene.Render(rotation), {}, NoiseModel(), {});
  EXPECT_NEAR(std::sqrt(result.squared_flow), 0.03 * 262.5, 1.5);
  EXPECT_LT(std::sqrt(result.squared_translation_flow), 0.5);
}

TEST(AlignFrame, AnotherSceneIsABadFit) {
  const PlaneScene scene;
  ImageF noise(320, 240);
  std::mt19937_64 generator = SeededGenerator(31, 0);
  std::uniform_real_distribution<float> uniform(0, 255);
  for (size_t i = 0; i < noise.size(); ++i) noise.data()[i] = uniform(generator);
  EXPECT_NE(AlignFrame(scene.Reference(), BuildPyramid(noise, 6), {}, NoiseModel(), {}).status,
            AlignmentStatus::kGood);
}

TEST(AlignFrame, WithoutPointsThereIsNothingToAlignTo) {
  const PlaneScene scene;
  EXPECT_EQ(AlignFrame(TrackingReference{}, scene.reference_image(), {}, NoiseModel(), {}).status,
            AlignmentStatus::kTooFewPoints);
}

TEST(Tracker, FollowsAMotionAcrossAChangeOfReference) {
  const PlaneScene scene;
  Tracker tracker{TrackerOptions{}};
  tracker.Start(scene.Reference(), scene.reference_image(), 0);
  const Vector6d velocity = (Vector6d() << 0.03, 0.01, 0, 0, 0.02, 0).finished();
  for (int i = 1; i <= 3; ++i) {
    const SE3 truth = SE3::Exp(i * velocity);
    const TrackingResult result = tracker.Track(scene.Render(truth), i * kFrame_ns, NoiseModel());
    ASSERT_EQ(result.status, TrackingStatus::kGood) << "frame " << i;
    EXPECT_LT((result.alignment.state.target_from_reference * truth.Inverse()).Log().norm(), 2e-3);
    // Nothing predicts the first, so that it is looked for.
    EXPECT_EQ(result.attempts == 1, i > 1) << "frame " << i;
  }
}

TEST(Tracker, PredictsOverTheTimeThatHasPassed) {
  const PlaneScene scene;
  Tracker tracker{TrackerOptions{}};
  tracker.Start(scene.Reference(), scene.reference_image(), 0);
  // 12 px a frame; three frames are missing. From a prediction for one frame the match would have
  // to be looked for.
  const Vector6d velocity = (Vector6d() << 0, 0, 0, 0, 0.045, 0).finished();
  int64_t frame = 0;
  for (const int step : {1, 1, 4, 1}) {
    frame += step;
    const SE3 truth = SE3::Exp(static_cast<double>(frame) * velocity);
    const TrackingResult result =
        tracker.Track(scene.Render(truth), frame * kFrame_ns, NoiseModel());
    ASSERT_EQ(result.status, TrackingStatus::kGood) << "frame " << frame;
    EXPECT_EQ(result.attempts == 1, frame > 1) << "frame " << frame;
    EXPECT_LT((result.alignment.state.target_from_reference * truth.Inverse()).Log().norm(), 2e-3);
  }
}

TEST(Tracker, FindsAQuickMotionFromNothing) {
  const PlaneScene scene;
  // 35 to 60 px of 320.
  for (const Vector6d& motion : {AxisMotion(3, 0.15),
                                 AxisMotion(4, 0.15),
                                 AxisMotion(4, -0.2),
                                 AxisMotion(5, 0.3),
                                 AxisMotion(0, 0.3),
                                 AxisMotion(1, -0.3)}) {
    Tracker tracker{TrackerOptions{}};
    tracker.Start(scene.Reference(), scene.reference_image(), 0);
    const SE3 truth = SE3::Exp(motion);
    const TrackingResult result = tracker.Track(scene.Render(truth), kFrame_ns, NoiseModel());
    ASSERT_EQ(result.status, TrackingStatus::kGood) << motion.transpose();
    EXPECT_LT((result.alignment.state.target_from_reference * truth.Inverse()).Log().norm(), 2e-3)
        << motion.transpose();
    // From then on velocity is known, the first frame being the reference.
    EXPECT_EQ(tracker.Track(scene.Render(truth * truth), 2 * kFrame_ns, NoiseModel()).attempts, 1)
        << motion.transpose();
  }
}

// Stripes fit a period aside as well, but for the little that tells one from the other.
TEST(Tracker, AtTheStartTheBestOfSeveralGoodMatchesIsTaken) {
  const PlaneScene scene([](double x, double y) {
    constexpr double kPeriod_m = 0.25;
    return 128 + 60 * std::sin(2 * M_PI * x / kPeriod_m) + 0.15 * (PlaneTexture(x, y) - 128);
  });
  for (const double angle : {0.06, -0.06, 0.08, -0.08}) {
    Tracker tracker{TrackerOptions{}};
    tracker.Start(scene.Reference(), scene.reference_image(), 0);
    const SE3 truth = SE3::Exp(AxisMotion(4, angle));
    const TrackingResult result = tracker.Track(scene.Render(truth), kFrame_ns, NoiseModel());
    const SE3& found = result.alignment.state.target_from_reference;
    EXPECT_EQ(result.status, TrackingStatus::kGood) << angle;
    EXPECT_LT((found * truth.Inverse()).Log().norm(), 5e-3) << angle;
  }
}

TEST(Tracker, AtTheStartAMatchOfPartOfTheImageIsNone) {
  const PlaneScene scene;
  ImageF image = scene.reference_image()[0];
  std::mt19937_64 generator = SeededGenerator(32, 0);
  std::uniform_real_distribution<float> uniform(0, 255);
  for (int y = 0; y < 240; ++y) {
    for (int x = 180; x < 320; ++x) image(x, y) = uniform(generator);
  }
  Tracker tracker{TrackerOptions{}};
  tracker.Start(scene.Reference(), scene.reference_image(), 0);
  const TrackingResult result = tracker.Track(BuildPyramid(image, 6), kFrame_ns, NoiseModel());
  EXPECT_EQ(result.alignment.status, AlignmentStatus::kGood);
  EXPECT_EQ(result.status, TrackingStatus::kLost);
}

// As the focused image of a real camera: displaced by up to a pixel here and there.
TEST(Tracker, AtTheStartMisplacedTextureIsNoMismatch) {
  const PlaneScene scene;
  const SE3 motion = SE3::Exp(AxisMotion(0, 0.01));
  const ImageF sharp = scene.Render(motion)[0];
  ImageF image = sharp;
  for (int y = 4; y < 236; ++y) {
    for (int x = 4; x < 316; ++x) {
      const double dx = 1.2 * std::sin(0.31 * x + 0.23 * y),
                   dy = 1.2 * std::cos(0.27 * x - 0.29 * y);
      image(x, y) = static_cast<float>(InterpolateBilinear(sharp, x + dx, y + dy).value);
    }
  }
  Tracker tracker{TrackerOptions{}};
  tracker.Start(scene.Reference(), scene.reference_image(), 0);
  const TrackingResult result = tracker.Track(BuildPyramid(image, 6), kFrame_ns, NoiseModel());
  ASSERT_EQ(result.status, TrackingStatus::kGood);
  const SE3& found = result.alignment.state.target_from_reference;
  EXPECT_LT((found * motion.Inverse()).Log().head<3>().norm(), 0.003);
}

TEST(RankStarts, PutsTheTrueStartFirst) {
  const PlaneScene scene;
  const SE3 truth = SE3::Exp(AxisMotion(4, 0.2));
  std::vector<AlignmentState> starts(3);
  starts[1].target_from_reference = truth;
  starts[2].target_from_reference = truth.Inverse();
  const std::vector<AlignmentState> ranked =
      RankStarts(scene.Reference(), scene.Render(truth), starts, NoiseModel(), {});
  ASSERT_FALSE(ranked.empty());
  EXPECT_LT((ranked[0].target_from_reference * truth.Inverse()).Log().norm(), 0.02);
  EXPECT_TRUE(
      RankStarts(TrackingReference{}, scene.reference_image(), starts, NoiseModel(), {}).empty());
}

TEST(Tracker, ABlackFrameHasNoTexture) {
  const PlaneScene scene;
  Tracker tracker{TrackerOptions{}};
  tracker.Start(scene.Reference(), scene.reference_image(), 0);
  EXPECT_EQ(tracker.Track(BuildPyramid(ImageF(320, 240, 0.0f), 6), kFrame_ns, NoiseModel()).status,
            TrackingStatus::kNoTexture);
  EXPECT_EQ(tracker.Track(scene.reference_image(), 2 * kFrame_ns, NoiseModel()).status,
            TrackingStatus::kGood);
}

// Gray over the left part of a frame.
ImagePyramid Covered(const ImagePyramid& frame, int columns) {
  ImageF image = frame[0];
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < columns; ++x) image(x, y) = 120;
  }
  return BuildPyramid(std::move(image), 6);
}

TEST(JudgePoints, FindsThoseBehindAUniformSheet) {
  const PlaneScene scene;
  const TrackingReference reference = scene.Reference();
  std::vector<double> rho;
  for (const ReferencePoint& point : scene.points()) rho.push_back(point.rho);
  const ImagePyramid target = Covered(scene.reference_image(), 160);
  const PointFits points = JudgePoints(reference, target[0], {}, rho, NoiseModel());
  int wrong = 0;
  for (size_t i = 0; i < points.fits.size(); ++i) {
    const bool is_hidden = scene.points()[i].px.x() < 160;
    wrong += points.fits[i] != (is_hidden ? PointFit::kOutlier : PointFit::kFits);
  }
  EXPECT_LT(wrong, static_cast<int>(points.fits.size()) / 50);
  EXPECT_NEAR(points.OutlierFraction(), 0.5, 0.05);
  EXPECT_LT(points.rms, 1);
}

TEST(Tracker, LeavesOutWhatIsHiddenAndTakesItUpAgain) {
  const PlaneScene scene;
  Tracker tracker{TrackerOptions{}};
  tracker.Start(scene.Reference(), scene.reference_image(), 0);
  NoiseModel noise;
  for (int i = 0; i < 3; ++i) noise.Observe(noise.FitSigma());  // it is known what fits
  const Vector6d velocity = (Vector6d() << 0.004, 0.002, 0, 0, 0.002, 0).finished();
  const auto excluded = [&] {
    int count = 0;
    for (const ReferencePoint& point : tracker.reference().points) count += point.is_excluded;
    return count;
  };
  for (int i = 1; i <= 6; ++i) {
    const SE3 truth = SE3::Exp(i * velocity);
    const bool is_covered = i >= 2 && i <= 4;
    const ImagePyramid image = scene.Render(truth);
    const TrackingResult result =
        tracker.Track(is_covered ? Covered(image, 160) : image, i * kFrame_ns, noise);
    ASSERT_EQ(result.status, TrackingStatus::kGood) << "frame " << i;
    EXPECT_LT((result.alignment.state.target_from_reference * truth.Inverse()).Log().norm(), 2e-3)
        << "frame " << i;
    if (i == 4) {
      EXPECT_GT(excluded(), static_cast<int>(scene.points().size()) / 3);
    }
  }
  EXPECT_EQ(excluded(), 0);
}

TEST(Tracker, TakesAChangeOfExposureFromTheImages) {
  const PlaneScene scene;
  for (const float gain : {0.3f, 0.5f, 1.8f}) {
    Tracker tracker{TrackerOptions{}};
    tracker.Start(scene.Reference(), scene.reference_image(), 0);
    ImageF image = scene.Render(SE3::Exp(AxisMotion(0, 0.02)))[0];
    for (size_t i = 0; i < image.size(); ++i) {
      image.data()[i] = std::min(gain * image.data()[i], 255.0f);
    }
    const TrackingResult result =
        tracker.Track(BuildPyramid(std::move(image), 6), kFrame_ns, NoiseModel());
    ASSERT_EQ(result.status, TrackingStatus::kGood) << gain;
    EXPECT_NEAR(result.alignment.state.a, std::log(gain), 0.02);
    EXPECT_LT(
        (result.alignment.state.target_from_reference * SE3::Exp(AxisMotion(0, 0.02)).Inverse())
            .Log()
            .norm(),
        2e-3);
  }
}

TEST(NeedsKeyframe, WhenTheImageHasMovedFarEnough) {
  FrameAlignmentResult alignment;
  alignment.fit.visible_fraction = 1;
  alignment.fit.outlier_fraction = 0;
  alignment.points.rms = 5;
  EXPECT_FALSE(NeedsKeyframe(alignment, 5, 640, 480, {}));
  alignment.squared_translation_flow = alignment.squared_flow = 60 * 60;
  EXPECT_TRUE(NeedsKeyframe(alignment, 5, 640, 480, {}));
}

TEST(NeedsKeyframe, WhenBrightnessRotationVisibilityOrFitHaveChanged) {
  FrameAlignmentResult same;
  same.fit.visible_fraction = 1;
  same.fit.outlier_fraction = 0;
  same.points.rms = 5;
  FrameAlignmentResult alignment = same;
  alignment.state.a = 0.5;
  EXPECT_TRUE(NeedsKeyframe(alignment, 5, 640, 480, {}));
  alignment = same;
  alignment.state.target_from_reference = SE3::Exp(AxisMotion(5, 0.5));
  EXPECT_TRUE(NeedsKeyframe(alignment, 5, 640, 480, {}));
  alignment = same;
  alignment.fit.visible_fraction = 0.4;
  EXPECT_TRUE(NeedsKeyframe(alignment, 5, 640, 480, {}));
  alignment = same;
  alignment.points.rms = 12;
  EXPECT_TRUE(NeedsKeyframe(alignment, 5, 640, 480, {}));
}

}  // namespace
}  // namespace prism
