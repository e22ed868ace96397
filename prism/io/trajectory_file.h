// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/scene/trajectory.h"

namespace prism {

// Trajectory files of this and of other systems. Poses are world_from_cam, lengths in metres.
//
//   TUM    "time tx ty tz qx qy qz qw", time in seconds; what this project writes
//   EuRoC  "time,px,py,pz,qw,qx,qy,qz[,...]", time in nanoseconds; further columns are not read
//   KITTI  the 12 numbers of [R | t] row by row; the times come from elsewhere
//
// Empty lines and lines that begin with '#' are skipped.
enum class TrajectoryFormat { kAuto, kTum, kEuroc, kKitti };

struct TrajectoryReadOptions {
  // kAuto decides by the first line: a comma is EuRoC, 12 columns are KITTI, all else is TUM.
  TrajectoryFormat format = TrajectoryFormat::kAuto;
  // Only for KITTI, one of the two: a file with one time in seconds a line, or a rate (the first
  // pose then has time 0).
  std::string kitti_times_path;
  double kitti_rate_hz = 0;
};

// Throws InputError, naming file and line, for a file that cannot be read or holds no pose, a line
// with missing or unreadable numbers, NaN and infinity, times that do not increase, and rotations
// further than 0.05 from unit length (or from orthonormal, KITTI). Rotations that are nearer but
// not unit are normalised; if the difference exceeds rounding to 4 decimals a warning says so.
Trajectory ReadTrajectory(const std::string& path, const TrajectoryReadOptions& options = {});

// The TUM text: seconds with 9 decimals (exact), values with 9 significant digits.
std::string FormatTrajectory(const Trajectory& trajectory);

// Writes it, whole or not at all. Throws InputError if that cannot be done.
void WriteTrajectory(const std::string& path, const Trajectory& trajectory);

}  // namespace prism
