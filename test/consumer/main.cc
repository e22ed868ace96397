// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// Odometry in a program of one's own, with a residual of one's own if asked for:
//   consumer SEQUENCE CAMERA OUTPUT_DIR [--planar]
#include <cstdio>
#include <string>
#include <utility>

#include <prism/base/error.h>
#include <prism/io/trajectory_file.h>
#include <prism/odometry/odometry.h>
#include <prism/run/sequence.h>

#include "planar_motion.h"

int main(int argc, char** argv) {
  const bool is_planar = argc == 5 && std::string(argv[4]) == "--planar";
  if (argc != 4 && !is_planar) {
    std::fprintf(stderr, "Usage: consumer SEQUENCE CAMERA OUTPUT_DIR [--planar]\n");
    return 2;
  }
  try {
    prism::SequenceOptions sequence_options;
    sequence_options.sequence = argv[1];
    sequence_options.camera = argv[2];
    prism::Sequence sequence(sequence_options);

    prism::OdometryOptions options;
    if (is_planar) {
      options.terms.push_back(std::make_shared<PlanarMotionTerm>(PlanarMotionOptions()));
    }
    prism::Odometry odometry(sequence.camera(), options);
    while (auto frame = sequence.Next()) {
      const prism::FrameResult result = odometry.Process(std::move(*frame));
      std::printf(
          "%.3f s: %s\n", 1e-9 * static_cast<double>(result.time_ns), ToString(result.status));
    }
    const std::string output_dir = argv[3];
    prism::WriteTrajectory(output_dir + "/trajectory.txt", odometry.FrameTrajectory());
    prism::WriteTrajectory(output_dir + "/keyframes.txt", odometry.KeyframeTrajectory());
  } catch (const prism::InputError& error) {
    std::fprintf(stderr, "consumer: %s\n", error.what());
    return 2;
  }
}
