// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <variant>

#include "prism/camera/plenoptic_camera.h"

namespace prism {

// Calibration files. Millimetres in the files, metres in the structs; every reader throws
// InputError (file, found, expected) on a file that cannot be read or parsed, a missing or unknown
// key, a figure that is no finite number, and a camera whose IsValid says no.

using AnyCamera = std::variant<PlenopticCamera, PinholeCamera>;

// The format is told by the name: .yaml or .yml is the native format (either model, see
// calib/README.md for the keys), .xml a LiFCal CameraModel.xml (plenoptic, without a micro-lens
// grid), .txt the line `fx fy cx cy width height` (px, # comments; pinhole).
AnyCamera ReadCamera(const std::string& path);

// ReadCamera for a caller that needs one model; InputError if the file holds the other. The metric
// one also throws where HasMetricDepth says no.
PlenopticCamera ReadPlenopticCamera(const std::string& path);
PlenopticCamera ReadMetricCamera(const std::string& path);
PinholeCamera ReadPinholeCamera(const std::string& path);

// A micro-lens grid: Raytrix RayCalibData (.xml), or the micro_lens_grid of a native camera
// (.yaml). Of a Raytrix file's `rotation` only what its base vectors do not hold already is kept in
// MicroLensGrid::rotation: the difference to the angle of lens_base_x where the two are within 0.1
// rad (an R5's pi/2, which is in both), else all of it.
MicroLensGrid ReadMicroLensGrid(const std::string& path);

// Gives a camera the grid of a file, and its mode where the file says one.
void AddMicroLensGrid(const std::string& path, PlenopticCamera* camera);

// Throws InputError naming `path` where HasMetricDepth says no.
void RequireMetricDepth(const PlenopticCamera& camera, const std::string& path);

// ---- writers, atomic; InputError if the file cannot be written ----

// Native YAML; numbers with 15 digits, so that reading returns the same camera to 1e-15 of each.
void WriteNativeCamera(const std::string& path, const AnyCamera& camera);

// LiFCal CameraModel.xml: image size and principal point in focused px, pixel size of a raw pixel.
// Holds no grid, and no focused_scale (readers assume 2): precondition focused_scale == 2.
void WriteLifcalCamera(const std::string& path, const PlenopticCamera& camera);

// Raytrix RayCalibData; the rotation is put into the base vectors.
void WriteRaytrixGrid(const std::string& path, const MicroLensGrid& grid);

}  // namespace prism
