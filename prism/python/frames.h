// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "prism/camera/plenoptic_camera.h"
#include "prism/image/image.h"
#include "prism/scene/frame.h"
#include "prism/scene/trajectory.h"

namespace prism {

// Arrays that are of another type, or not in rows, are converted by pybind11.
using FloatArray = pybind11::array_t<float, pybind11::array::c_style | pybind11::array::forcecast>;

// A frame of the odometry from what a user has: gray 0 to 255, 1/v and its standard deviation, all
// on the camera's focused grid; 0 = no measurement. Raises ValueError for another shape.
LightFieldFrame MakeFrame(const PlenopticCamera& camera,
                          int64_t time_ns,
                          const FloatArray& image,
                          const FloatArray& inverse_virtual_depth,
                          const FloatArray& sigma);

// A raw image as it is decoded: 8 or 16 bits, one channel or three (BGR), without a copy; the frame
// must not outlive the array. Raises ValueError for another shape or type.
RawFrame MakeRawFrame(const PlenopticCamera& camera, int64_t time_ns, const pybind11::array& image);

// The pixels of an image as an array that owns them.
pybind11::array_t<float> ArrayOf(ImageF image);

// Rows `time tx ty tz qx qy qz qw`, world_from_cam, seconds and metres; and back.
pybind11::array_t<double> ArrayOf(const Trajectory& trajectory);
Trajectory TrajectoryOf(const pybind11::array_t<double>& rows);

}  // namespace prism
