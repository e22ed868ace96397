// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/python/frames.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "prism/image/pyramid.h"

namespace prism {
namespace {

namespace py = pybind11;

constexpr int kPyramidLevels = 5;  // as of focused sequences

ImageF ImageOf(const FloatArray& array, const PlenopticCamera& camera, const char* name) {
  const int width = camera.focused_width(), height = camera.focused_height();
  if (array.ndim() != 2 || array.shape(0) != height || array.shape(1) != width) {
    throw py::value_error(std::string(name) + ": expected an array of " + std::to_string(height) +
                          " x " + std::to_string(width) + ", the camera's focused image");
  }
  ImageF image(width, height);
  std::copy_n(array.data(), image.size(), image.data());
  return image;
}

}  // namespace

LightFieldFrame MakeFrame(const PlenopticCamera& camera,
                          int64_t time_ns,
                          const FloatArray& image,
                          const FloatArray& inverse_virtual_depth,
                          const FloatArray& sigma) {
  LightFieldFrame frame;
  frame.time_ns = time_ns;
  frame.depth_correlation_px = kMicroImageDepthCorrelation;
  frame.image = BuildPyramid(ImageOf(image, camera, "image"), kPyramidLevels);
  frame.inverse_virtual_depth = ImageOf(inverse_virtual_depth, camera, "inverse_virtual_depth");
  frame.sigma = ImageOf(sigma, camera, "sigma");
  for (size_t i = 0; i < frame.sigma.size(); ++i) {
    float& w = frame.inverse_virtual_depth.data()[i];
    float& s = frame.sigma.data()[i];
    if (!(w > 0 && w <= 0.5f && s > 0)) w = s = 0;
  }
  return frame;
}

RawFrame MakeRawFrame(const PlenopticCamera& camera, int64_t time_ns, const py::array& image) {
  const bool is_8 = py::isinstance<py::array_t<uint8_t>>(image);
  const bool is_16 = py::isinstance<py::array_t<uint16_t>>(image);
  const bool has_channels = image.ndim() == 3 && image.shape(2) == 3;
  if (!(is_8 || is_16) || !(image.ndim() == 2 || has_channels) ||
      image.shape(0) != camera.raw_height || image.shape(1) != camera.raw_width) {
    throw py::value_error("image: expected uint8 or uint16 of " +
                          std::to_string(camera.raw_height) + " x " +
                          std::to_string(camera.raw_width) + " or so many x 3 (BGR)");
  }
  if ((image.flags() & py::array::c_style) == 0) {
    throw py::value_error("image: expected rows one after the other (numpy.ascontiguousarray)");
  }
  RawFrame frame;
  frame.time_ns = time_ns;
  frame.path = "array";
  frame.image = cv::Mat(camera.raw_height,
                        camera.raw_width,
                        CV_MAKETYPE(is_8 ? CV_8U : CV_16U, has_channels ? 3 : 1),
                        const_cast<void*>(image.data()));  // NOLINT: read only
  return frame;
}

py::array_t<float> ArrayOf(ImageF image) {
  auto owner = std::make_unique<ImageF>(std::move(image));
  const py::ssize_t height = owner->height(), width = owner->width();
  float* data = owner->data();
  const py::capsule keeper(owner.release(),
                           [](void* image) { delete static_cast<ImageF*>(image); });
  return py::array_t<float>({height, width}, data, keeper);
}

py::array_t<double> ArrayOf(const Trajectory& trajectory) {
  py::array_t<double> rows({static_cast<py::ssize_t>(trajectory.size()), py::ssize_t{8}});
  auto row = rows.mutable_unchecked<2>();
  for (size_t i = 0; i < trajectory.size(); ++i) {
    const auto r = static_cast<py::ssize_t>(i);
    const Eigen::Vector3d t = trajectory[i].world_from_cam.translation();
    const Eigen::Quaterniond q = trajectory[i].world_from_cam.rotation();
    row(r, 0) = 1e-9 * static_cast<double>(trajectory[i].time_ns);
    for (int k = 0; k < 3; ++k) row(r, 1 + k) = t(k);
    for (int k = 0; k < 4; ++k) row(r, 4 + k) = q.coeffs()(k);
  }
  return rows;
}

Trajectory TrajectoryOf(const py::array_t<double>& rows) {
  if (rows.ndim() != 2 || rows.shape(1) != 8) {
    throw py::value_error("trajectory: expected rows of time tx ty tz qx qy qz qw");
  }
  Trajectory trajectory;
  const auto row = rows.unchecked<2>();
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    trajectory.push_back({std::llround(1e9 * row(i, 0)),
                          SE3(Eigen::Quaterniond(row(i, 7), row(i, 4), row(i, 5), row(i, 6)),
                              Eigen::Vector3d(row(i, 1), row(i, 2), row(i, 3)))});
    if (i > 0 && trajectory[i].time_ns <= trajectory[i - 1].time_ns) {
      throw py::value_error("trajectory: expected times that increase");
    }
  }
  return trajectory;
}

}  // namespace prism
