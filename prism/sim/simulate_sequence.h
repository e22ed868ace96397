// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>

#include "prism/camera/plenoptic_camera.h"
#include "prism/sim/motion.h"
#include "prism/sim/renderer.h"
#include "prism/sim/sensor.h"
#include "prism/sim/sim_scene.h"

namespace prism {

struct SimulateOptions {
  OpticsOptions optics;
  RenderOptions render;
  SensorOptions sensor;
  double exposure_s = 0.004;     // motion blur; 0: none
  double exposure_change = 0.0;  // relative amplitude of a slow change of brightness, 0.08: 8 %
  int truth_every = 10;          // depth truth of every Nth frame; 0: none
  bool preview = false;          // a conventional view of every frame
  bool replace = false;          // removes frames of another description instead of refusing

  bool IsValid(std::string* error) const;
};

struct SimulateProgress {
  int frame = 0;        // frames done, old and new
  int num_frames = 0;   // of the sequence
  bool reused = false;  // it was there already
  double seconds = 0;   // this frame took
};

// Renders a raw sequence (design, Section 3) into a folder: raw/NNNNNN.png and raw.txt, white.png,
// camera.yaml, CameraModel.xml, MLA_Calibration.xml, groundtruth.txt, for every Nth frame
// virtual_depth_truth/NNNNNN.png (1/v = 1 - value / 65535 on the focused grid, 0 none) and
// depth_truth/NNNNNN.tiff (32-bit float, m, 0 none), preview/NNNNNN.png if wanted.
//
// Frames already there are kept, so a stopped run goes on where it was; `description` (all that
// determines the pictures) is stored in simulate.txt and must be the same, or what is there is
// removed first if options.replace says so. raw.txt is written last:
// a folder with it is complete. Brightness is set once so that 1 % of a preview is overexposed.
//
// Throws InputError: a pose inside geometry or nearer to a surface than twice the focal length
// (naming `motion_name`), another description, files that cannot be written. No file is left half
// written.
void SimulateSequence(const SimScene& scene,
                      const PlenopticCamera& camera,
                      const CameraMotion& motion,
                      const std::string& motion_name,
                      const SimulateOptions& options,
                      const std::string& description,
                      const std::string& output_dir,
                      const std::function<void(const SimulateProgress&)>& on_frame);

}  // namespace prism
