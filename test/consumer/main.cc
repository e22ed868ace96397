// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// Odometry in a program of one's own: consumer SEQUENCE CAMERA TRAJECTORY
#include <cstdio>
#include <utility>

#include <prism/base/error.h>
#include <prism/io/trajectory_file.h>
#include <prism/odometry/odometry.h>
#include <prism/run/sequence.h>

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "Usage: consumer SEQUENCE CAMERA TRAJECTORY\n");
    return 2;
  }
  try {
    prism::SequenceOptions options;
    options.sequence = argv[1];
    options.camera = argv[2];
    prism::Sequence sequence(options);
    prism::Odometry odometry(sequence.camera(), prism::OdometryOptions());
    while (auto frame = sequence.Next()) {
      const prism::FrameResult result = odometry.Process(std::move(*frame));
      std::printf(
          "%.3f s: %s\n", 1e-9 * static_cast<double>(result.time_ns), ToString(result.status));
    }
    prism::WriteTrajectory(argv[3], odometry.FrameTrajectory());
  } catch (const prism::InputError& error) {
    std::fprintf(stderr, "consumer: %s\n", error.what());
    return 2;
  }
}
