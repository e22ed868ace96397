// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "prism/export/export_run.h"
#include "prism/odometry/odometry.h"
#include "prism/run/play_order.h"

namespace prism {

// Keeps the keyframes' images and depth while a run goes on, which the window forgets, and writes
// the run in the formats of --export at its end.
class ExportRecorder {
 public:
  // A comma list of formats; empty: nothing is kept and nothing written. Throws InputError for a
  // name that is none.
  explicit ExportRecorder(const std::string& formats);

  // To be called after every Odometry::Process.
  void Add(const FrameResult& frame, const Odometry& odometry);

  // Of a map in pieces the one with most keyframes is written; returns a line a format. Throws
  // InputError if a file cannot be written.
  std::string Write(const std::string& folder,
                    const Odometry& odometry,
                    const PlayOrder& play_order) const;

 private:
  std::vector<std::string> formats_;
  std::vector<ExportKeyframe> keyframes_;  // without final poses
};

}  // namespace prism
