// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/motion.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <glog/logging.h>
#include <Eigen/Geometry>

#include "prism/sim/counter_random.h"

namespace prism {
namespace {

// A sum of sines of given frequencies (Hz) with random phases and weights; value and bounded by
// about 1.
class Wander {
 public:
  Wander(const std::vector<double>& frequencies_hz, CounterRandom* random) {
    for (const double hz : frequencies_hz) {
      terms_.push_back({2 * M_PI * hz,
                        2 * M_PI * random->Uniform(),
                        (0.5 + random->Uniform()) / static_cast<double>(frequencies_hz.size())});
    }
  }
  double operator()(double t) const {
    double sum = 0;
    for (const Term& term : terms_) sum += term.weight * std::sin(term.omega * t + term.phase);
    return sum;
  }

 private:
  struct Term {
    double omega, phase, weight;
  };
  std::vector<Term> terms_;
};

// Six independent wanders: three of position, three of angle.
struct Wander6 {
  Wander6(const std::vector<double>& frequencies_hz, CounterRandom* random) {
    for (int i = 0; i < 6; ++i) axes.emplace_back(frequencies_hz, random);
  }
  Vector6d operator()(double t, double position, double angle) const {
    Vector6d value;
    for (int i = 0; i < 6; ++i) value[i] = (i < 3 ? position : angle) * axes[i](t);
    return value;
  }
  std::vector<Wander> axes;
};

// world_from_cam at a position looking at a target, x to the right of the world's vertical.
SE3 LookAt(const Eigen::Vector3d& position, const Eigen::Vector3d& target) {
  const Eigen::Vector3d z = (target - position).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d R;
  R << x, z.cross(x), z;
  return SE3(Eigen::Quaterniond(R), position);
}

Vector6d Twist(double x, double y, double z, double pitch, double yaw, double roll) {
  Vector6d twist;
  twist << x, y, z, pitch, yaw, roll;
  return twist;
}

// Camera-frame offset (position in metres, rotation vector) from the start pose at time t.
using Offset = std::function<Vector6d(double t)>;

Offset MakeOffset(const MotionOptions& options, double extent) {
  CounterRandom random(options.seed, static_cast<uint64_t>(options.kind), 0);
  const double duration = std::max(options.num_frames - 1, 1) / options.rate_hz;
  const Wander6 slow({0.11, 0.19, 0.31}, &random);
  const Wander6 tremor({2.1, 4.7, 7.9}, &random);
  const Wander6 violent({1.9, 3.1, 4.3}, &random);
  // Whole periods over the run, so that a loop closes.
  const auto periods = [&](std::vector<double> counts) {
    for (double& count : counts) count /= duration;
    return counts;
  };
  const double tremor_periods = std::round(3.7 * duration);
  const Wander6 closed_tremor(periods({tremor_periods, tremor_periods + 5}), &random);
  constexpr double kTremor = 0.0012;      // m
  constexpr double kTremorAngle = 0.002;  // rad
  switch (options.kind) {
    case MotionKind::kHandheld:
      return [=](double t) -> Vector6d {
        return slow(t, extent, 0.2) - slow(0, extent, 0.2) + tremor(t, kTremor, kTremorAngle);
      };
    case MotionKind::kShake:
      return [=](double t) -> Vector6d {
        return slow(t, 0.5 * extent, 0.1) - slow(0, 0.5 * extent, 0.1) + violent(t, 0.035, 0.07);
      };
    case MotionKind::kRotation:
      return [=](double t) -> Vector6d {
        const double phase = 2 * M_PI * t / std::max(duration, 4.0);
        return Twist(
            0, 0, 0, 0.12 * std::sin(2 * phase), 0.35 * std::sin(phase), 0.05 * std::sin(phase));
      };
    case MotionKind::kForward:
      return [=](double t) -> Vector6d {
        const double steps = 2 * M_PI * 1.8 * t;
        return Twist(0.012 * std::sin(0.5 * steps),
                     0.015 * std::sin(steps),
                     extent * t / duration,
                     0.006 * std::sin(steps),
                     0.01 * std::sin(0.5 * steps),
                     0) +
               tremor(t, kTremor, kTremorAngle);
      };
    case MotionKind::kLoop:
      break;
  }
  return [=](double t) -> Vector6d {
    const double phase = 2 * M_PI * t / duration;
    // An ellipse to the right and ahead, gently up and down, looking about.
    return Twist(extent * std::sin(phase),
                 -0.25 * extent * (1 - std::cos(2 * phase)) / 2,
                 0.8 * extent * (1 - std::cos(phase)),
                 0.06 * std::sin(2 * phase),
                 -0.22 * std::sin(phase),
                 0.04 * std::sin(phase)) +
           closed_tremor(t, kTremor, kTremorAngle) - closed_tremor(0, kTremor, kTremorAngle);
  };
}

}  // namespace

Trajectory CameraMotion::AtFrames() const {
  Trajectory trajectory;
  for (const int64_t time_ns : frame_times_ns) {
    trajectory.push_back({time_ns, world_from_cam(1e-9 * static_cast<double>(time_ns))});
  }
  return trajectory;
}

bool MotionOptions::IsValid(std::string* error) const {
  if (num_frames < 1 || num_frames > 1000000) {
    *error = std::to_string(num_frames) + " frames, expected 1 to 1000000";
  } else if (!(rate_hz > 0 && rate_hz <= 1e6)) {
    *error = "a rate of " + std::to_string(rate_hz) + " Hz, expected more than 0";
  } else {
    return true;
  }
  return false;
}

bool ParseMotionKind(const std::string& text, MotionKind* kind) {
  static const auto* kinds =
      new std::map<std::string, MotionKind>{{"handheld", MotionKind::kHandheld},
                                            {"loop", MotionKind::kLoop},
                                            {"rotation", MotionKind::kRotation},
                                            {"forward", MotionKind::kForward},
                                            {"shake", MotionKind::kShake}};
  const auto found = kinds->find(text);
  if (found == kinds->end()) return false;
  *kind = found->second;
  return true;
}

CameraMotion GenerateMotion(const MotionOptions& options, const SimPath& path) {
  CameraMotion motion;
  for (int i = 0; i < options.num_frames; ++i) {
    motion.frame_times_ns.push_back(std::llround(1e9 * i / options.rate_hz));
  }
  const SE3 world_from_start = LookAt(path.position, path.target);
  const Offset offset = MakeOffset(options, path.extent);
  motion.world_from_cam = [=](double seconds) {
    const Vector6d d = offset(seconds);
    const double angle = d.tail<3>().norm();
    const Eigen::Vector3d axis =
        angle > 0 ? Eigen::Vector3d(d.tail<3>() / angle) : Eigen::Vector3d::UnitX();
    return world_from_start * SE3(Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis)), d.head<3>());
  };
  return motion;
}

CameraMotion FollowTrajectory(const Trajectory& trajectory) {
  CHECK(!trajectory.empty());
  CameraMotion motion;
  for (const StampedPose& pose : trajectory) motion.frame_times_ns.push_back(pose.time_ns);
  motion.world_from_cam = [trajectory](double seconds) {
    const auto time_ns = static_cast<int64_t>(std::llround(1e9 * seconds));
    const auto after = std::lower_bound(
        trajectory.begin(), trajectory.end(), time_ns, [](const StampedPose& pose, int64_t t) {
          return pose.time_ns < t;
        });
    if (after == trajectory.begin()) return trajectory.front().world_from_cam;
    if (after == trajectory.end()) return trajectory.back().world_from_cam;
    const StampedPose& before = *(after - 1);
    const double fraction = static_cast<double>(time_ns - before.time_ns) /
                            static_cast<double>(after->time_ns - before.time_ns);
    const SE3 step = after->world_from_cam * before.world_from_cam.Inverse();
    return SE3::Exp(fraction * step.Log()) * before.world_from_cam;
  };
  return motion;
}

}  // namespace prism
