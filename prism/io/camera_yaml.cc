// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/camera_yaml.h"

#include <array>
#include <sstream>

#include <yaml-cpp/yaml.h>

#include "prism/base/error.h"
#include "prism/io/yaml_section.h"

namespace prism {
namespace {

MicroLensGrid ReadGrid(const std::string& path, const YAML::Node& node) {
  YamlSection section(path, "micro_lens_grid", node);
  MicroLensGrid grid;
  grid.diameter_px = section.Value<double>("diameter_px", "the micro-image pitch in raw px");
  grid.rotation = section.ValueOr("rotation_rad", grid.rotation, "an angle in rad");
  grid.offset_px = section.Vector<2>("offset_px", "[x, y] in raw px from the image centre, y up");
  grid.base_x = section.Vector<2>("base_x", "[x, y] in diameters, y up");
  grid.base_y = section.Vector<2>("base_y", "[x, y] in diameters, y up");
  grid.lens_border_px = section.ValueOr("lens_border_px", grid.lens_border_px, "a width in raw px");
  grid.total_covering_plane =
      section.ValueOr("total_covering_plane", grid.total_covering_plane, "a virtual depth");
  const YAML::Node types = section.Get("lens_types", "a list of 1 or 3 micro-lens types");
  section.RejectUnknownKeys();
  grid.types.clear();
  if (types.size() > 3) {
    throw InputError(path, std::to_string(types.size()) + " lens_types", "1 or 3");
  }
  for (const YAML::Node& type_node : types) {
    YamlSection type_section(path, "micro_lens_grid.lens_types", type_node);
    MicroLensType type;
    type.offset = type_section.Vector<2>("offset", "[x, y] in diameters, y up");
    const Eigen::Vector2d range =
        type_section.Vector<2>("virtual_depth_range", "[min, max] virtual depth");
    type.min_virtual_depth = range.x();
    type.max_virtual_depth = range.y();
    type_section.RejectUnknownKeys();
    grid.types.push_back(type);
  }
  return grid;
}

MicroLensMode ReadMode(const std::string& path, YamlSection& section) {
  constexpr char kModes[] = "'galilean' or 'keplerian'";
  const std::string text = section.ValueOr("mode", std::string("galilean"), kModes);
  for (const MicroLensMode mode : {MicroLensMode::kGalilean, MicroLensMode::kKeplerian}) {
    if (text == ToString(mode)) return mode;
  }
  throw InputError(path, "the mode '" + text + "'", kModes);
}

PlenopticCamera ReadPlenoptic(const std::string& path, YamlSection& section) {
  PlenopticCamera camera;
  camera.mode = ReadMode(path, section);
  const std::array<int, 2> size = section.Size("image_size_px");
  camera.raw_width = size[0];
  camera.raw_height = size[1];
  camera.raw_pixel_size = 1e-3 * section.Value<double>("pixel_size_mm", "a raw pixel's side in mm");
  camera.focal_length = 1e-3 * section.Value<double>("focal_length_mm", "f_L in mm");
  camera.main_lens_mla_distance =
      1e-3 * section.Value<double>("main_lens_mla_distance_mm", "b_L0 in mm");
  camera.sensor_mla_distance = 1e-3 * section.Value<double>("sensor_mla_distance_mm", "B in mm");
  camera.raw_principal_point = section.Vector<2>("principal_point_px", "[x, y] in raw px");
  camera.focused_scale =
      section.ValueOr("focused_scale", camera.focused_scale, "raw width / focused width");
  const std::string focused_image =
      section.ValueOr("focused_image", std::string(ToString(camera.focused_image)), kFocusedImages);
  if (!ParseFocusedImage(focused_image, &camera.focused_image)) {
    throw InputError(path, "the focused_image '" + focused_image + "'", kFocusedImages);
  }
  camera.adjust_micro_lens_centers = section.ValueOr(
      "adjust_micro_lens_centers", camera.adjust_micro_lens_centers, "true or false");
  if (section.Has("distortion")) {
    YamlSection distortion(path, "distortion", section.Get("distortion", ""));
    camera.distortion.A0 = 1e6 * distortion.ValueOr("A0_per_mm2", 0.0, "a number in 1/mm^2");
    camera.distortion.A1 = 1e12 * distortion.ValueOr("A1_per_mm4", 0.0, "a number in 1/mm^4");
    camera.distortion.B0 = 1e3 * distortion.ValueOr("B0_per_mm", 0.0, "a number in 1/mm");
    camera.distortion.B1 = 1e3 * distortion.ValueOr("B1_per_mm", 0.0, "a number in 1/mm");
    distortion.RejectUnknownKeys();
  }
  if (section.Has("micro_lens_grid")) {
    camera.micro_lens_grid = ReadGrid(path, section.Get("micro_lens_grid", ""));
  }
  return camera;
}

PinholeCamera ReadPinhole(YamlSection& section) {
  PinholeCamera camera;
  const std::array<int, 2> size = section.Size("image_size_px");
  camera.width = size[0];
  camera.height = size[1];
  const Eigen::Vector2d f = section.Vector<2>("focal_length_px", "[fx, fy] in px");
  camera.fx = f.x();
  camera.fy = f.y();
  const Eigen::Vector2d c = section.Vector<2>("principal_point_px", "[cx, cy] in px");
  camera.cx = c.x();
  camera.cy = c.y();
  return camera;
}

AnyCamera ReadNode(const std::string& path, const YAML::Node& node) {
  constexpr char kModels[] = "'plenoptic' or 'pinhole'";
  YamlSection section(path, "", node);
  const auto model = section.Value<std::string>("model", kModels);
  AnyCamera camera;
  if (model == "plenoptic") {
    camera = ReadPlenoptic(path, section);
  } else if (model == "pinhole") {
    camera = ReadPinhole(section);
  } else {
    throw InputError(path, "the model '" + model + "'", kModels);
  }
  section.RejectUnknownKeys();
  return camera;
}

std::string Pair(double x, double y) {
  std::ostringstream stream;
  stream.precision(15);
  stream << "[" << x << ", " << y << "]";
  return stream.str();
}

std::string Pair(const Eigen::Vector2d& v) { return Pair(v.x(), v.y()); }

void WriteGrid(const MicroLensGrid& grid, std::ostream& out) {
  out << "micro_lens_grid:  # y up, from the image centre\n"
      << "  diameter_px: " << grid.diameter_px << "\n"
      << "  rotation_rad: " << grid.rotation << "\n"
      << "  offset_px: " << Pair(grid.offset_px) << "\n"
      << "  base_x: " << Pair(grid.base_x) << "  # diameters\n"
      << "  base_y: " << Pair(grid.base_y) << "\n"
      << "  lens_border_px: " << grid.lens_border_px << "\n"
      << "  total_covering_plane: " << grid.total_covering_plane << "  # virtual depth\n"
      << "  lens_types:\n";
  for (const MicroLensType& type : grid.types) {
    out << "    - {offset: " << Pair(type.offset)
        << ", virtual_depth_range: " << Pair(type.min_virtual_depth, type.max_virtual_depth)
        << "}\n";
  }
}

}  // namespace

AnyCamera ReadCameraYaml(const std::string& path) {
  return ParseYamlFile(
      path, "a camera in YAML", [&](const YAML::Node& node) { return ReadNode(path, node); });
}

std::string CameraYaml(const PlenopticCamera& camera) {
  std::ostringstream out;
  out.precision(15);
  const Distortion& d = camera.distortion;
  out << "model: plenoptic\n"
      << "mode: " << ToString(camera.mode) << "\n"
      << "image_size_px: [" << camera.raw_width << ", " << camera.raw_height << "]  # raw\n"
      << "pixel_size_mm: " << 1e3 * camera.raw_pixel_size << "\n"
      << "focal_length_mm: " << 1e3 * camera.focal_length << "\n"
      << "main_lens_mla_distance_mm: " << 1e3 * camera.main_lens_mla_distance << "\n"
      << "sensor_mla_distance_mm: " << 1e3 * camera.sensor_mla_distance << "\n"
      << "principal_point_px: " << Pair(camera.raw_principal_point) << "  # raw\n"
      << "focused_scale: " << camera.focused_scale << "\n"
      << "adjust_micro_lens_centers: " << (camera.adjust_micro_lens_centers ? "true" : "false")
      << "\n";
  if (camera.focused_image != FocusedImage::kVirtualPoints) {
    out << "focused_image: " << ToString(camera.focused_image) << "\n";
  }
  if (!d.IsZero()) {
    out << "distortion: {A0_per_mm2: " << 1e-6 * d.A0 << ", A1_per_mm4: " << 1e-12 * d.A1
        << ", B0_per_mm: " << 1e-3 * d.B0 << ", B1_per_mm: " << 1e-3 * d.B1 << "}\n";
  }
  if (camera.micro_lens_grid) WriteGrid(*camera.micro_lens_grid, out);
  return out.str();
}

std::string CameraYaml(const PinholeCamera& camera) {
  std::ostringstream out;
  out << "model: pinhole\n"
      << "image_size_px: [" << camera.width << ", " << camera.height << "]\n"
      << "focal_length_px: " << Pair(camera.fx, camera.fy) << "\n"
      << "principal_point_px: " << Pair(camera.cx, camera.cy) << "\n";
  return out.str();
}

}  // namespace prism
