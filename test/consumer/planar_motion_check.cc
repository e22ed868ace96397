// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// Whether the estimate obeys a residual of one's own, before and after keyframes are marginalised:
//   planar_motion_check SEQUENCE CAMERA
// The sequence is one that is not planar (uneven_floor.txt): a term that claims it is, more
// certainly than the images can deny it, has to be seen in every keyframe. Exit status 1: it is
// not.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include <prism/base/error.h>
#include <prism/odometry/odometry.h>
#include <prism/run/sequence.h>
#include <prism/verify/jacobian_check.h>

#include "planar_motion.h"

namespace {

using prism::SE3;

// z of the scene's world in the first camera, which looks down a little.
const Eigen::Vector3d kUp = Eigen::Vector3d(0, -0.95, -0.16).normalized();
// Far below what the images tell (some 0.03 mm), so that the term decides. They still pull: what is
// left of a millimetre, or a milliradian, is 10 to 20 um (urad).
constexpr double kSigma = 1e-6;  // m and rad
constexpr double kHeld = 1e-4;   // m and rad: with the term no keyframe is beyond it
constexpr double kFree = 1e-3;   // without it some are, in tilt and in height
// The prior alone against raising all its keyframes by 1 mm, in standard deviations. All else that
// it knows of the height is the anchor of the first keyframe, with 0.01 mm.
constexpr double kAnchor = 100;
constexpr double kTermInPrior = 20;  // what the term adds to it at the least

bool all_hold = true;

void Expect(bool holds, const std::string& what, double value) {
  std::printf("%s: %s (%.4g)\n", holds ? "ok" : "FAILED", what.c_str(), value);
  all_hold &= holds;
}

struct Deviation {
  double tilt = 0;    // rad
  double height = 0;  // m
  void Raise(const SE3& world_from_cam) {
    const Eigen::Vector3d up = world_from_cam.RotationMatrix() * kUp;
    tilt = std::max(tilt, up.cross(kUp).norm());
    height = std::max(height, std::abs(kUp.dot(world_from_cam.translation())));
  }
  double Worst() const { return std::max(tilt, height); }
};

struct Run {
  int tracked = 0;
  int keyframes = 0;
  int retired = 0;
  Deviation before;             // of keyframes of the window, until the first one retires
  Deviation after;              // of those of the window from then on
  Deviation all;                // of all, as they were when the window last held them
  int optimizations = 0;        // of the window
  int summaries = 0;            // that list the term, with a factor for every keyframe
  double variance_factor = -1;  // of the term, in the last of them
  double prior_cost = 0;        // see kAnchor
};

double CostOfRaising(const prism::LinearPrior& prior, double metres) {
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(prior.A.cols());
  Eigen::Index column = 0;
  for (const prism::LinearPrior::Block& block : prior.blocks) {
    if (block.kind->name == "frame state") {
      // cam_from_world moves by exp(delta) on the left, translation first.
      const SE3 cam_from_world(block.linearization.data());
      delta.segment<3>(column) = -metres * (cam_from_world.RotationMatrix() * kUp);
    }
    column += block.kind->TangentSize();
  }
  return (prior.A * delta).norm();
}

Run Process(const prism::SequenceOptions& sequence_options, const prism::TermList& terms) {
  prism::Sequence sequence(sequence_options);
  prism::OdometryOptions options;
  options.terms = terms;
  options.window.max_keyframes = 4;  // few, so that they retire soon
  options.window.solve.threads = 1;
  // The term bends depths. Frames are not asked whether they measure the same.
  options.tracker.fit.start.min_depth_agreement = 0;
  options.tracker.fit.match.min_depth_agreement = 0;
  prism::Odometry odometry(sequence.camera(), options);
  Run run;
  while (auto frame = sequence.Next()) {
    const prism::FrameResult result = odometry.Process(std::move(*frame));
    run.tracked += result.status == prism::FrameStatus::kTracked;
    if (!result.is_keyframe) continue;
    ++run.keyframes;
    const size_t held = odometry.window().keyframes.size();
    run.retired = run.keyframes - static_cast<int>(held);
    for (const auto& keyframe : odometry.window().keyframes) {
      (run.retired == 0 ? run.before : run.after).Raise(keyframe->state.pose().Inverse());
    }
    const auto& summaries = result.keyframe.optimization.terms;
    run.optimizations += !summaries.empty();
    for (const prism::TermSummary& term : summaries) {
      if (term.name != "planar motion") continue;
      // The window may have lost keyframes since it was optimised.
      run.summaries += term.factors >= static_cast<int>(held) && term.factors <= 4;
      run.variance_factor = term.variance_factor;
    }
  }
  for (const prism::StampedPose& keyframe : odometry.KeyframeTrajectory()) {
    run.all.Raise(keyframe.world_from_cam);
  }
  run.prior_cost = CostOfRaising(odometry.window().prior, 1e-3);
  return run;
}

void CheckJacobian(const prism::PlenopticCamera& camera) {
  const prism::TermList terms = {std::make_shared<PlanarMotionTerm>(PlanarMotionOptions())};
  const prism::JacobianCheckResult result = prism::CheckJacobians(camera, terms, {});
  Expect(result.agrees, "all Jacobians agree with numeric differences", result.valid_samples);
  double largest = 0;  // a term without factors would agree as well
  for (const prism::JacobianBlockCheck& block : result.blocks) {
    if (block.residual == "term: planar motion") largest = block.largest_element;
  }
  Expect(largest > 0, "the term's was among them, largest element", largest);
}

void CheckRuns(const prism::SequenceOptions& sequence) {
  PlanarMotionOptions tight;
  tight.up = kUp;
  tight.tilt_sigma = tight.height_sigma = kSigma;
  const Run with = Process(sequence, {std::make_shared<PlanarMotionTerm>(tight)});
  const Run without = Process(sequence, {});

  for (const Run* run : {&with, &without}) {
    std::printf("%s the term:\n", run == &with ? "with" : "without");
    Expect(run->tracked > 20, "frames are tracked", run->tracked);
    Expect(run->retired >= 2, "two keyframes or more have retired", run->retired);
  }
  Expect(without.all.tilt > kFree, "without it the camera tilts, rad", without.all.tilt);
  Expect(without.all.height > kFree, "and rises, m", without.all.height);
  Expect(without.summaries == 0, "and no figures are listed", without.summaries);
  Expect(with.before.Worst() < kHeld, "with it neither before a retirement", with.before.Worst());
  Expect(with.after.Worst() < kHeld, "nor after", with.after.Worst());
  Expect(with.all.Worst() < kHeld, "nor in a keyframe that has retired", with.all.Worst());
  Expect(with.optimizations > 2 && with.summaries == with.optimizations,
         "its figures are listed for every optimisation",
         with.summaries);
  Expect(with.variance_factor > 1, "images contradict: variance factor", with.variance_factor);
  Expect(without.prior_cost < 1.1 * kAnchor, "prior without it, 1 mm up", without.prior_cost);
  const double added = std::sqrt(std::pow(with.prior_cost, 2) - std::pow(without.prior_cost, 2));
  Expect(added > kTermInPrior, "the term adds to the prior, 1 mm up", added);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "Usage: planar_motion_check SEQUENCE CAMERA\n");
    return 2;
  }
  try {
    prism::SequenceOptions sequence;
    sequence.sequence = argv[1];
    sequence.camera = argv[2];
    CheckJacobian(prism::Sequence(sequence).camera());
    CheckRuns(sequence);
  } catch (const prism::InputError& error) {
    std::fprintf(stderr, "planar_motion_check: %s\n", error.what());
    return 2;
  }
  return all_hold ? 0 : 1;
}
