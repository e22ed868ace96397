// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "prism/odometry/odometry.h"
#include "prism/run/play_order.h"
#include "prism/scene/trajectory.h"
#include "tools/run_record.h"

namespace prism {

// Removes what an earlier run has left in the folder. Throws InputError if that cannot be done.
void ClearResults(const std::string& folder);

// Writes trajectory.txt and keyframes.txt into the folder, where the map fell into pieces
// trajectory_segmentN.txt of each. Throws InputError if a file cannot be written.
void WritePoses(const std::string& folder, const Odometry& odometry, const PlayOrder& play_order);

// The poses, points.ply and run.json: all that can be written. Throws InputError if one cannot.
void WriteRun(const std::string& folder,
              const RunRecord& record,
              const Odometry& odometry,
              const PlayOrder& play_order);

// The run's figures in some lines.
void PrintRun(const std::string& folder, const RunRecord& record, const Odometry& odometry);

// At the very end: what made the run less than it could have been.
void PrintEnd(const RunRecord& record);

// Closes the loops of a copy of the map (Map::CloseLoops), writes trajectory_closed.txt,
// keyframes_closed.txt and points_closed.ply, and prints what came of it, against `groundtruth` if
// it is not empty. Throws InputError if a file cannot be written.
void WriteClosedMap(const std::string& folder,
                    const Odometry& odometry,
                    const PlayOrder& play_order,
                    const Trajectory& groundtruth);

// Writes the places of the first piece of the map, and of what is loaded if that is part of it, for
// later runs (WriteMap). Throws InputError if that cannot be done.
void SaveMap(const std::string& folder, const Odometry& odometry);

// Compares with the ground truth, as it was played: the final trajectory, and the poses as they
// were known when each frame came (ate_online_rmse_m). Writes metrics.json into the folder and
// prints the main figures. Throws InputError if the file cannot be written.
void WriteMetrics(const std::string& folder,
                  const RunRecord& record,
                  const Odometry& odometry,
                  const Trajectory& groundtruth);

}  // namespace prism
