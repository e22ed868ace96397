// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "prism/scene/trajectory.h"
#include "prism/sim/sim_scene.h"

namespace prism {

// Where the camera is at any moment, and when frames are taken (middle of the exposure).
struct CameraMotion {
  std::vector<int64_t> frame_times_ns;
  std::function<SE3(double seconds)> world_from_cam;

  Trajectory AtFrames() const;
};

enum class MotionKind {
  kHandheld,  // smooth wandering about the start, with tremor
  kLoop,      // out and round and back to exactly the first pose
  kRotation,  // turning on the spot, no translation at all
  kForward,   // walking towards the target, with the bob of steps
  kShake,     // handheld with fast, wide shaking
};

struct MotionOptions {
  MotionKind kind = MotionKind::kLoop;
  int num_frames = 60;
  double rate_hz = 15;
  uint64_t seed = 1;  // of phases, amplitudes and tremor

  bool IsValid(std::string* error) const;
};

// "handheld", "loop", "rotation", "forward" or "shake"; false for other words.
bool ParseMotionKind(const std::string& text, MotionKind* kind);

// A motion about a scene's path; the camera looks roughly at its target with its y axis down.
CameraMotion GenerateMotion(const MotionOptions& options, const SimPath& path);

// Frames at the poses of a trajectory, straight (constant twist) between them; still before the
// first and after the last. Precondition: not empty.
CameraMotion FollowTrajectory(const Trajectory& trajectory);

}  // namespace prism
