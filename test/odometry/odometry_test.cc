// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/odometry/odometry.h"

#include <cmath>

#include <gtest/gtest.h>

#include "prism/base/statistics.h"
#include "test/map/speckle_texture.h"
#include "test/window/synthetic_window.h"

namespace prism {
namespace {

SyntheticOptions Scene() {
  SyntheticOptions options;
  options.width = 320;
  options.height = 240;
  return options;
}

SE3 TruePose(int frame) {
  const double s = 0.1 * frame;
  return SE3::Exp((Vector6d() << 0.15 * s,
                   0.05 * std::sin(2 * s),
                   0.03 * s,
                   0.02 * std::sin(s),
                   0.05 * s,
                   0.03 * std::sin(3 * s))
                      .finished());
}

LightFieldFrame TrueFrame(int frame,
                          const SE3& pose,
                          double w_sigma = 0.002,
                          const Texture& texture = PlaneTexture) {
  const PlenopticProjection camera(SyntheticCamera(Scene()));
  std::mt19937_64 generator = SeededGenerator(77, frame);
  std::normal_distribution<double> normal;
  LightFieldFrame rendered = *RenderPlane(camera, pose, 1, &generator, texture);
  for (size_t i = 0; i < rendered.sigma.size(); ++i) {
    rendered.inverse_virtual_depth.data()[i] += static_cast<float>(w_sigma * normal(generator));
    rendered.sigma.data()[i] = static_cast<float>(w_sigma);
  }
  rendered.time_ns = frame * int64_t{50'000'000};
  return rendered;
}

LightFieldFrame BlackFrame(int frame) {
  LightFieldFrame black;
  black.time_ns = frame * int64_t{50'000'000};
  black.image = BuildPyramid(ImageF(320, 240, 0.0f), 6);
  black.inverse_virtual_depth = ImageF(320, 240, 0.0f);
  black.sigma = ImageF(320, 240, 0.0f);
  return black;
}

OdometryOptions TestOptions() {
  OdometryOptions options;
  options.window.max_points = 600;
  options.window.solve.threads = 1;
  return options;
}

// Largest distance of estimated from true camera centres, both relative to a frame of the list.
double LargestError(const Trajectory& trajectory, size_t first, size_t count) {
  const SE3 world_from_truth = trajectory[first].world_from_cam *
                               TruePose(static_cast<int>(trajectory[first].time_ns / 50'000'000));
  double largest = 0;
  for (size_t i = first; i < first + count; ++i) {
    const SE3 truth =
        world_from_truth * TruePose(static_cast<int>(trajectory[i].time_ns / 50'000'000)).Inverse();
    largest = std::max(largest,
                       (truth.translation() - trajectory[i].world_from_cam.translation()).norm());
  }
  return largest;
}

TEST(Odometry, FollowsAMetricPath) {
  Odometry odometry(SyntheticCamera(Scene()), TestOptions());
  int keyframes = 0;
  for (int i = 0; i < 30; ++i) {
    const FrameResult result = odometry.Process(TrueFrame(i, TruePose(i)));
    EXPECT_EQ(result.status, FrameStatus::kTracked) << "frame " << i;
    keyframes += result.is_keyframe;
  }
  EXPECT_GT(keyframes, 3);
  const Trajectory trajectory = odometry.FrameTrajectory();
  ASSERT_EQ(trajectory.size(), 30u);
  const double path =
      (TruePose(29).Inverse().translation() - TruePose(0).Inverse().translation()).norm();
  EXPECT_GT(path, 0.3);
  EXPECT_LT(LargestError(trajectory, 0, 30), 0.01 * path);
  EXPECT_GT(odometry.MapPoints().size(), 500u);
  EXPECT_EQ(static_cast<int>(odometry.KeyframeTrajectory().size()), keyframes);
}

TEST(Odometry, MapPointsLieOnThePlane) {
  Odometry odometry(SyntheticCamera(Scene()), TestOptions());
  for (int i = 0; i < 20; ++i) odometry.Process(TrueFrame(i, TruePose(i)));
  // World is the first camera, which stands at the origin of the plane's coordinates.
  std::vector<double> distances;
  for (const MapPoint& point : odometry.MapPoints()) {
    distances.push_back(std::abs(Eigen::Vector3d(-0.2, 0.1, 1).dot(point.p_in_world) - 2));
  }
  EXPECT_LT(Quantile(distances, 0.5), 0.02);
}

TEST(Odometry, IsDeterministicOnOneThread) {
  Trajectory first;
  for (int run = 0; run < 2; ++run) {
    Odometry odometry(SyntheticCamera(Scene()), TestOptions());
    for (int i = 0; i < 15; ++i) odometry.Process(TrueFrame(i, TruePose(i)));
    const Trajectory trajectory = odometry.FrameTrajectory();
    if (run == 0) first = trajectory;
    for (size_t i = 0; i < first.size(); ++i) {
      for (int k = 0; k < 7; ++k) {
        EXPECT_EQ(first[i].world_from_cam.data()[k], trajectory[i].world_from_cam.data()[k]);
      }
    }
  }
}

TEST(Odometry, ABlackFrameIsNotTrackedAndTheRunGoesOn) {
  Odometry odometry(SyntheticCamera(Scene()), TestOptions());
  for (int i = 0; i < 20; ++i) {
    const bool is_black = i == 10 || i == 11;
    const FrameResult result =
        odometry.Process(is_black ? BlackFrame(i) : TrueFrame(i, TruePose(i)));
    EXPECT_EQ(result.status, is_black ? FrameStatus::kNoTexture : FrameStatus::kTracked)
        << "frame " << i;
    EXPECT_EQ(result.segment, 0);
  }
  const Trajectory trajectory = odometry.FrameTrajectory();
  EXPECT_EQ(trajectory.size(), 18u);
  EXPECT_LT(LargestError(trajectory, 0, 18), 0.01);
}

TEST(Odometry, AfterALossThatCannotBeMendedANewMetricSegmentStarts) {
  Odometry odometry(SyntheticCamera(Scene()), TestOptions());
  // From frame 12 on the camera looks at another part of the plane.
  const SE3 elsewhere = SE3::Exp((Vector6d() << 1.3, 0.9, 0, 0, 0, 0.8).finished());
  int lost = 0, new_segment = 0;
  for (int i = 0; i < 30; ++i) {
    const SE3 pose = i < 12 ? TruePose(i) : elsewhere * TruePose(i);
    const FrameResult result = odometry.Process(TrueFrame(i, pose));
    lost += result.status == FrameStatus::kLost;
    new_segment += result.segment == 1 && result.status == FrameStatus::kTracked;
  }
  EXPECT_EQ(lost, TestOptions().max_lost_frames);
  EXPECT_EQ(new_segment, 30 - 12 - lost);
  const Trajectory trajectory = odometry.FrameTrajectory();
  const size_t start = 12;
  // Metric from its first frame: lengths within the segment are true.
  const double estimated = (trajectory.back().world_from_cam.translation() -
                            trajectory[start].world_from_cam.translation())
                               .norm();
  const auto center = [&](int64_t time_ns) -> Eigen::Vector3d {
    return (elsewhere * TruePose(static_cast<int>(time_ns / 50'000'000))).Inverse().translation();
  };
  const double truth =
      (center(trajectory.back().time_ns) - center(trajectory[start].time_ns)).norm();
  EXPECT_NEAR(estimated / truth, 1, 0.03);
}

TEST(Odometry, AFrameWithoutDepthCannotStart) {
  Odometry odometry(SyntheticCamera(Scene()), TestOptions());
  EXPECT_EQ(odometry.Process(BlackFrame(0)).status, FrameStatus::kNoTexture);
  EXPECT_EQ(odometry.Process(TrueFrame(1, TruePose(1))).status, FrameStatus::kTracked);
}

TEST(Odometry, FramesBetweenKeyframesGetPosesThatAgreeWithTheirDepthsAtLast) {
  // Depths of the first frame are uncertain: frames tracked on it are off until the first keyframe
  // after it has been optimised.
  Odometry odometry(SyntheticCamera(Scene()), TestOptions());
  std::vector<FrameResult> results;
  int keyframes = 0;
  for (int i = 0; keyframes < 3; ++i) {
    ASSERT_LT(i, 60);
    results.push_back(odometry.Process(TrueFrame(i, TruePose(i), 0.006)));
    keyframes += results.back().is_keyframe;
  }
  const auto rms = [](const Trajectory& trajectory) {
    double sum = 0;
    for (size_t i = 0; i < trajectory.size(); ++i) {
      const SE3 truth = TruePose(static_cast<int>(i)).Inverse();
      sum += (trajectory[i].world_from_cam.translation() - truth.translation()).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(trajectory.size()));
  };
  Trajectory online;
  for (const FrameResult& result : results) {
    online.push_back({result.time_ns, result.state.pose().Inverse()});
  }
  EXPECT_LT(rms(odometry.FrameTrajectory()), rms(online));
}

// Every frame of a run of `count`, each changed by `disturb(frame number, frame)` before.
template <typename Disturb>
void ExpectAllTracked(int count, double largest_error, const Disturb& disturb) {
  Odometry odometry(SyntheticCamera(Scene()), TestOptions());
  for (int i = 0; i < count; ++i) {
    LightFieldFrame frame = TrueFrame(i, TruePose(i));
    disturb(i, &frame);
    const FrameResult result = odometry.Process(std::move(frame));
    EXPECT_EQ(result.status, FrameStatus::kTracked) << "frame " << i;
    EXPECT_EQ(result.segment, 0) << "frame " << i;
  }
  const Trajectory trajectory = odometry.FrameTrajectory();
  ASSERT_EQ(trajectory.size(), static_cast<size_t>(count));
  EXPECT_LT(LargestError(trajectory, 0, trajectory.size()), largest_error);
}

template <typename Change>
void ChangeImage(LightFieldFrame* frame, const Change& change) {
  ImageF image = frame->image[0];
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) image(x, y) = change(x, y, image(x, y));
  }
  frame->image = BuildPyramid(std::move(image), 6);
}

TEST(Odometry, AnExposureThatHalvesOrDoublesIsFollowed) {
  for (const float gain : {0.4f, 2.4f}) {
    ExpectAllTracked(20, 0.01, [&](int i, LightFieldFrame* frame) {
      const float factor = i < 10 ? 0.5f : 0.5f * gain;
      ChangeImage(frame, [&](int, int, float v) { return std::min(factor * v, 255.0f); });
    });
  }
}

TEST(Odometry, AUniformSheetOverHalfTheViewDoesNotHarm) {
  ExpectAllTracked(26, 0.012, [](int i, LightFieldFrame* frame) {
    const bool is_covered = i >= 8 && i < 20;
    // Weak texture, whose mean is near the sheet's gray.
    ChangeImage(frame, [&](int x, int, float v) {
      return is_covered && x < 180 ? 120.0f : 140 + 0.6f * (v - 128);
    });
    if (!is_covered) return;
    for (int y = 0; y < 240; ++y) {
      for (int x = 0; x < 180; ++x) frame->sigma(x, y) = 0;
    }
  });
}

TEST(Odometry, APatchThatMovesByItselfDoesNotHarm) {
  ExpectAllTracked(24, 0.012, [](int i, LightFieldFrame* frame) {
    if (i < 6) return;
    const int left = 20 + 7 * (i - 6), top = 60;  // 140 x 110 of 320 x 240 px
    ChangeImage(frame, [&](int x, int y, float v) {
      const int u = x - left, w = y - top;
      if (u < 0 || w < 0 || u >= 140 || w >= 110) return v;
      return static_cast<float>(128 + 50 * std::sin(0.4 * u) * std::cos(0.3 * w) +
                                30 * std::sin(0.11 * u + 0.07 * w));
    });
  });
}

TEST(Odometry, DepthsThatTheirNeighboursContradictAreNotUsed) {
  ExpectAllTracked(20, 0.012, [](int i, LightFieldFrame* frame) {
    std::mt19937_64 generator = SeededGenerator(5, i);
    std::uniform_real_distribution<float> uniform;
    for (size_t k = 0; k < frame->sigma.size(); ++k) {
      if (uniform(generator) < 0.3f) {
        frame->inverse_virtual_depth.data()[k] += 0.3f * (uniform(generator) - 0.7f);
      }
    }
  });
}

// Windows whose depths are off by more than assumed fit badly, and would stay so.
TEST(Odometry, LearnsByHowMuchDepthsOfAFrameAreOffInCommon) {
  constexpr double kOffsetSigma = 0.003;
  Odometry odometry(SyntheticCamera(Scene()), TestOptions());
  for (int i = 0; i < 40; ++i) {
    LightFieldFrame frame = TrueFrame(i, TruePose(i));
    std::mt19937_64 generator = SeededGenerator(6, i);
    const double offset = kOffsetSigma * std::normal_distribution<double>()(generator);
    for (size_t k = 0; k < frame.sigma.size(); ++k) {
      frame.inverse_virtual_depth.data()[k] += static_cast<float>(offset);
    }
    EXPECT_EQ(odometry.Process(std::move(frame)).status, FrameStatus::kTracked) << "frame " << i;
  }
  EXPECT_GT(odometry.window().noise.DepthOffsetSigma(), 1.5 * NoiseModel().DepthOffsetSigma());
}

TEST(Odometry, AFrameWhoseOwnDepthsDisagreeIsNotTaken) {
  Odometry odometry(SyntheticCamera(Scene()), TestOptions());
  for (int i = 0; i < 12; ++i) {
    LightFieldFrame frame = TrueFrame(i, TruePose(i));
    if (i == 8) {
      for (size_t k = 0; k < frame.sigma.size(); ++k)
        frame.inverse_virtual_depth.data()[k] += 0.03f;
    }
    EXPECT_EQ(odometry.Process(std::move(frame)).status,
              i == 8 ? FrameStatus::kDepthsDisagree : FrameStatus::kTracked)
        << "frame " << i;
  }
}

TEST(OdometryOptions, RefuseWhatMakesNoSense) {
  const auto is_valid = [](const auto& change) {
    OdometryOptions options;
    change(&options);
    std::string error;
    const bool valid = options.IsValid(&error);
    EXPECT_EQ(valid, error.empty());
    return valid;
  };
  using Options = OdometryOptions;
  EXPECT_TRUE(is_valid([](Options*) {}));
  EXPECT_FALSE(is_valid([](Options* o) { o->default_terms.photometric.outliers.quantile = -0.1; }));
  EXPECT_FALSE(is_valid([](Options* o) { o->default_terms.photometric.cauchy = -1; }));
  EXPECT_FALSE(is_valid([](Options* o) { o->default_terms.depth.max_residual = 0; }));
  EXPECT_FALSE(is_valid([](Options* o) { o->window.solve.max_iterations = 0; }));
  EXPECT_FALSE(is_valid([](Options* o) { o->window.solve.function_tolerance = NAN; }));
  EXPECT_FALSE(is_valid([](Options* o) { o->window.max_keyframes = 2; }));
  EXPECT_FALSE(is_valid([](Options* o) { o->photometric_model_sigma = -3; }));
  EXPECT_FALSE(is_valid([](Options* o) { o->retirement.max_log_gain = -1; }));
  EXPECT_FALSE(is_valid([](Options* o) { o->activation.refinement.max_iterations = -1; }));
  EXPECT_FALSE(is_valid([](Options* o) { o->activation.candidates.min_matches = -1; }));
  EXPECT_FALSE(
      is_valid([](Options* o) { o->activation.candidates.search.refinement_iterations = -1; }));
  EXPECT_FALSE(is_valid([](Options* o) { o->tracker.fit.good.max_rms = -1; }));
  EXPECT_FALSE(is_valid([](Options* o) { o->tracker.fit.recovered.min_depth_agreement = 1.5; }));
  EXPECT_FALSE(is_valid([](Options* o) { o->tracker.alignment.level.depth_huber = 0; }));
  EXPECT_FALSE(is_valid([](Options* o) { o->keyframe.min_visible_fraction = -0.5; }));
  EXPECT_FALSE(is_valid([](Options* o) { o->terms = {nullptr}; }));
}

LightFieldFrame SpeckleFrame(int frame, const SE3& pose) {
  return TrueFrame(frame, pose, 0.002, SpeckleTexture);
}

// The true pose of a frame of the kidnapped camera: along the path, then, from frame 22 on, along
// it once more.
SE3 KidnappedPose(int frame) { return TruePose(frame < 22 ? frame : frame - 18); }

TEST(Odometry, AKidnappedCameraIsFoundInWhatItSawBeforeAndJoined) {
  Odometry odometry(SyntheticCamera(Scene()), TestOptions());
  int joins = 0, segments = 0;
  for (int i = 0; i < 40; ++i) {
    const FrameResult result =
        odometry.Process(i >= 18 && i < 22 ? BlackFrame(i) : SpeckleFrame(i, KidnappedPose(i)));
    joins += result.joined.has_value();
    segments = std::max(segments, result.segment + 1);
  }
  EXPECT_EQ(joins, segments - 1) << "all segments are joined";
  EXPECT_EQ(odometry.map().Pieces().size(), 1u);
  const Trajectory trajectory = odometry.FrameTrajectory();
  EXPECT_GE(trajectory.size(), 34u);
  const SE3 world_from_truth = trajectory[0].world_from_cam * KidnappedPose(0);
  for (const StampedPose& pose : trajectory) {
    const SE3 truth =
        world_from_truth * KidnappedPose(static_cast<int>(pose.time_ns / 50'000'000)).Inverse();
    EXPECT_LT((truth.translation() - pose.world_from_cam.translation()).norm(), 0.01)
        << "frame " << pose.time_ns / 50'000'000;
  }
}

TEST(Odometry, AfterALossItGoesOnWithTheDepthsThatTheMapKnows) {
  constexpr double kSigma = 0.006;
  // The camera rolls while it sees nothing: no alignment to the window gets that far.
  const SE3 roll = SE3::Exp((Vector6d() << 0, 0, 0, 0, 0, 1).finished());
  const auto frame = [&](int i, double sigma) {
    return TrueFrame(i, i < 22 ? TruePose(i) : roll * KidnappedPose(i), sigma, SpeckleTexture);
  };
  OdometryOptions options = TestOptions();
  options.window.max_keyframes = 4;
  Odometry odometry(SyntheticCamera(Scene()), options);
  FrameResult result;
  int i = 0;
  for (; i < 30 && result.segment == 0; ++i) {
    result = odometry.Process(i >= 18 && i < 22 ? BlackFrame(i) : frame(i, kSigma));
  }
  ASSERT_EQ(result.segment, 1);
  const LightFieldFrame& start = *odometry.window().newest().frame;
  const LightFieldFrame truth = frame(i - 1, 0);
  std::vector<double> errors;
  for (size_t j = 0; j < start.sigma.size(); ++j) {
    if (start.sigma.data()[j] > 0.5 * kSigma) continue;
    errors.push_back(
        std::abs(start.inverse_virtual_depth.data()[j] - truth.inverse_virtual_depth.data()[j]));
  }
  EXPECT_GT(errors.size(), 1000u);
  EXPECT_LT(Quantile(errors, 0.5), 0.3 * kSigma) << "0.67 as measured";
}

TEST(Odometry, WithoutJoiningAKidnappedCameraStaysInAPieceOfItsOwn) {
  OdometryOptions options = TestOptions();
  options.joining.join = false;
  Odometry odometry(SyntheticCamera(Scene()), options);
  const SE3 elsewhere = SE3::Exp((Vector6d() << 1.3, 0.9, 0, 0, 0, 0.8).finished());
  for (int i = 0; i < 40; ++i) {
    odometry.Process(SpeckleFrame(i, i < 20 ? TruePose(i) : elsewhere * TruePose(i)));
  }
  EXPECT_EQ(odometry.map().Pieces(), (std::vector<int>{0, 1}));
  EXPECT_EQ(odometry.map().FrameTrajectory(0).size(), 20u);
}

TEST(Odometry, ARunIsFoundInTheMapOfAnEarlierOne) {
  Odometry first(SyntheticCamera(Scene()), TestOptions());
  for (int i = 0; i < 20; ++i) first.Process(SpeckleFrame(i, TruePose(i)));
  const std::vector<MappedPlace> places = first.CompleteMap().MappedPlaces(0);
  ASSERT_GE(places.size(), 3u);

  Odometry second(SyntheticCamera(Scene()), TestOptions());
  second.LoadPlaces(places);
  int settled = 0;
  const auto seen_at = [](size_t time) { return std::abs(19 - static_cast<int>(time)); };
  for (size_t time = 0; time < 39; ++time) {  // back and forth
    LightFieldFrame frame = SpeckleFrame(seen_at(time), TruePose(seen_at(time)));
    frame.time_ns = static_cast<int64_t>(100 + time) * 50'000'000;
    settled += second.Process(std::move(frame)).has_settled;
  }
  EXPECT_GE(settled, 1) << "keyframes after the join place the segment too";
  EXPECT_EQ(second.map().Pieces(), (std::vector<int>{kLoadedSegment}));
  const Trajectory again = second.FrameTrajectory();
  const Trajectory before = first.FrameTrajectory();
  for (size_t i = 0; i < again.size(); ++i) {
    const Eigen::Vector3d difference =
        again[i].world_from_cam.translation() - before[seen_at(i)].world_from_cam.translation();
    EXPECT_LT(difference.norm(), 0.005) << "frame " << seen_at(i);
  }
}

TEST(Odometry, AFrameThatShowsNothingHasAPredictedPoseWithARisingSigma) {
  Odometry odometry(SyntheticCamera(Scene()), TestOptions());
  for (int i = 0; i < 12; ++i) odometry.Process(SpeckleFrame(i, TruePose(i)));
  double sigma = 0;
  for (int i = 12; i < 16; ++i) {
    const FrameResult result = odometry.Process(BlackFrame(i));
    EXPECT_EQ(result.status, FrameStatus::kNoTexture);
    EXPECT_GT(result.sigma.translation_m, sigma);
    sigma = result.sigma.translation_m;
    const Eigen::Vector3d error =
        (result.state.pose() * TruePose(i).Inverse()).translation() - TruePose(0).translation();
    EXPECT_LT(error.norm(), 0.02) << "frame " << i;
  }
  EXPECT_EQ(odometry.FrameTrajectory().size(), 12u) << "predicted poses are none of the trajectory";
}

// A view of which all but a strip has become a blank wall.
LightFieldFrame NearlyBlankFrame(int frame, const SE3& pose) {
  LightFieldFrame blank = SpeckleFrame(frame, pose);
  ImageF image = blank.image[0];
  std::mt19937_64 generator = SeededGenerator(3, frame);
  std::normal_distribution<float> normal(128, 1);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width() - 50; ++x) {
      image(x, y) = normal(generator);
      blank.sigma(x, y) = blank.inverse_virtual_depth(x, y) = 0;
    }
  }
  blank.image = BuildPyramid(std::move(image), 6);
  return blank;
}

TEST(Odometry, APoorViewIsHeldByTheMotionBeforeAndTheWindowGoesOn) {
  Odometry odometry(SyntheticCamera(Scene()), TestOptions());
  for (int i = 0; i < 30; ++i) {
    const bool is_poor = i >= 12 && i < 20;
    const FrameResult result =
        odometry.Process(is_poor ? NearlyBlankFrame(i, TruePose(i)) : SpeckleFrame(i, TruePose(i)));
    EXPECT_EQ(result.status, is_poor ? FrameStatus::kHeld : FrameStatus::kTracked) << "frame " << i;
    EXPECT_EQ(result.segment, 0) << "frame " << i;
  }
  const Trajectory trajectory = odometry.FrameTrajectory();
  EXPECT_LT(LargestError(trajectory, 0, trajectory.size()), 0.02);
}

}  // namespace
}  // namespace prism
