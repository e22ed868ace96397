// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/camera/plenoptic_camera.h"

#include <cmath>
#include <sstream>

#include <glog/logging.h>

namespace prism {
namespace {

// Appends "NAME of VALUE, expected EXPECTED" to the first complaint only.
class Validator {
 public:
  explicit Validator(std::string* error) : error_(error) {}

  void Require(bool condition, const char* name, double value, const char* expected) {
    if (condition || !valid_) return;
    valid_ = false;
    std::ostringstream message;
    message << name << " of " << value << ", expected " << expected;
    *error_ = message.str();
  }
  bool valid() const { return valid_; }

 private:
  std::string* error_;
  bool valid_ = true;
};

bool IsPositive(double value) { return std::isfinite(value) && value > 0; }

// From the main lens to the plane of v = 2.
double PinholePlane(const PlenopticCamera& camera) {
  return camera.main_lens_mla_distance +
         2 * camera.virtual_depth_sign() * camera.sensor_mla_distance;
}

}  // namespace

const char* ToString(MicroLensMode mode) {
  return mode == MicroLensMode::kKeplerian ? "keplerian" : "galilean";
}

const char* ToString(FocusedImage image) {
  return image == FocusedImage::kChiefRays ? "chief_rays" : "virtual_points";
}

bool ParseFocusedImage(const std::string& name, FocusedImage* image) {
  for (const FocusedImage known : {FocusedImage::kVirtualPoints, FocusedImage::kChiefRays}) {
    if (name != ToString(known)) continue;
    *image = known;
    return true;
  }
  return false;
}

bool PlenopticCamera::IsValid(std::string* error) const {
  Validator validator(error);
  const double lengths_mm[] = {
      1e3 * focal_length, 1e3 * main_lens_mla_distance, 1e3 * sensor_mla_distance};
  validator.Require(IsPositive(lengths_mm[0]), "focal length (mm)", lengths_mm[0], "> 0");
  validator.Require(IsPositive(lengths_mm[1]), "main lens to MLA (mm)", lengths_mm[1], "> 0");
  validator.Require(IsPositive(lengths_mm[2]), "sensor to MLA (mm)", lengths_mm[2], "> 0");
  validator.Require(IsPositive(raw_pixel_size), "pixel size (mm)", 1e3 * raw_pixel_size, "> 0");
  validator.Require(raw_width >= 16, "image width", raw_width, ">= 16 px");
  validator.Require(raw_height >= 16, "image height", raw_height, ">= 16 px");
  validator.Require(
      focused_scale >= 1 && focused_scale <= 16, "focused scale", focused_scale, "1 to 16");
  validator.Require(std::isfinite(raw_principal_point.x()),
                    "principal point x",
                    raw_principal_point.x(),
                    "a number");
  validator.Require(std::isfinite(raw_principal_point.y()),
                    "principal point y",
                    raw_principal_point.y(),
                    "a number");
  for (const double coefficient : {distortion.A0, distortion.A1, distortion.B0, distortion.B1}) {
    validator.Require(
        std::isfinite(coefficient), "distortion coefficient", coefficient, "a number");
  }
  if (!validator.valid()) return false;
  return !micro_lens_grid || micro_lens_grid->IsValid(error);
}

bool PlenopticCamera::HasMetricDepth(std::string* error) const {
  Validator validator(error);
  validator.Require((focal_length - main_lens_mla_distance) * virtual_depth_sign() > 0,
                    "focal length (mm)",
                    1e3 * focal_length,
                    mode == MicroLensMode::kKeplerian
                        ? "less than the distance from main lens to MLA (Keplerian mode)"
                        : "more than the distance from main lens to MLA (Galilean mode; 'mode: "
                          "keplerian' for real images before the micro lenses)");
  return validator.valid();
}

bool PinholeCamera::IsValid(std::string* error) const {
  Validator validator(error);
  validator.Require(IsPositive(fx), "focal length fx (px)", fx, "> 0");
  validator.Require(IsPositive(fy), "focal length fy (px)", fy, "> 0");
  validator.Require(std::isfinite(cx), "principal point cx", cx, "a number");
  validator.Require(std::isfinite(cy), "principal point cy", cy, "a number");
  validator.Require(width >= 16, "image width", width, ">= 16 px");
  validator.Require(height >= 16, "image height", height, ">= 16 px");
  return validator.valid();
}

PlenopticCamera PlenopticFromPinhole(const PinholeCamera& pinhole, const PlenopticCamera& lens) {
  CHECK_LT(std::abs(pinhole.fx - pinhole.fy), 1e-6 * pinhole.fx);
  PlenopticCamera camera;
  camera.mode = lens.mode;
  camera.focal_length = lens.focal_length;
  camera.main_lens_mla_distance = lens.main_lens_mla_distance;
  camera.sensor_mla_distance = lens.sensor_mla_distance;
  camera.raw_width = pinhole.width;
  camera.raw_height = pinhole.height;
  camera.focused_scale = 1;
  camera.raw_pixel_size = PinholePlane(lens) / pinhole.fx;
  camera.raw_principal_point = {pinhole.cx, pinhole.cy};
  return camera;
}

PinholeCamera PinholeView(const PlenopticCamera& camera) {
  PinholeCamera pinhole;
  pinhole.width = camera.focused_width();
  pinhole.height = camera.focused_height();
  pinhole.fx = pinhole.fy = PinholePlane(camera) / (camera.raw_pixel_size * camera.focused_scale);
  pinhole.cx = (camera.raw_principal_point.x() + 0.5) / camera.focused_scale - 0.5;
  pinhole.cy = (camera.raw_principal_point.y() + 0.5) / camera.focused_scale - 0.5;
  return pinhole;
}

}  // namespace prism
