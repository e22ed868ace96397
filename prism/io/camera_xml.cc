// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/camera_xml.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include <glog/logging.h>
#include <Eigen/Geometry>
#include <pugixml.hpp>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"
#include "prism/io/camera_number.h"

namespace prism {
namespace {

constexpr int kLifcalFocusedScale = 2;
// Of one name, or unknown: more are no camera's.
constexpr size_t kMaxChildren = 20;
constexpr std::pair<const char*, double> kLengths_mm[] = {
    {"mm", 1}, {"um", 1e-3}, {"\u00b5m", 1e-3}, {"cm", 10}, {"m", 1e3}};
// A rotation this near to the angle of lens_base_x is taken to be in the base vectors already.
constexpr double kRotationInBaseVectors = 0.1;

// Of either format: whether the micro lenses see real images.
constexpr const char* kKeplerianElements[] = {"IsKepler", "isKepler", "isReal", "IsReal"};

// One element and the path to it, for messages.
class Element {
 public:
  Element(const std::string& file, const std::string& name, const pugi::xml_node& node)
      : file_(file), name_(name), node_(node) {
    if (!node) throw InputError(file, "no element '" + name + "'", "'" + name + "'");
  }

  bool Has(const char* name) const { return static_cast<bool>(node_.child(name)); }
  Element Child(const char* name) const { return {file_, name_ + "/" + name, node_.child(name)}; }
  std::string Text(const char* name) const { return Child(name).node_.text().as_string(); }
  double Number(const char* name) const {
    return ParseCameraNumber(Text(name), file_, "a number in '" + name_ + "/" + name + "'");
  }
  // A length in mm; the element may say that its number is in another unit.
  double LengthMm(const char* name) const {
    const std::string unit = Child(name).node_.attribute("units").as_string("mm");
    for (const auto& [known, mm] : kLengths_mm) {
      if (unit == known) return mm * Number(name);
    }
    throw InputError(file_, "'" + name_ + "/" + name + "' in '" + unit + "'", "mm, um, cm or m");
  }
  double NumberOr(const char* name, double fallback) const {
    return Has(name) ? Number(name) : fallback;
  }
  Eigen::Vector2d Vector(const char* name) const {
    return {Child(name).Number("x"), Child(name).Number("y")};
  }
  std::vector<Element> Children(const char* name) const {
    std::vector<Element> children;
    for (const pugi::xml_node& child : node_.children(name)) {
      if (children.size() == kMaxChildren) {
        throw InputError(file_,
                         "more than " + std::to_string(kMaxChildren) + " elements '" + name + "'",
                         "the figures of one camera");
      }
      children.emplace_back(file_, name_ + "/" + name, child);
    }
    return children;
  }
  void WarnOfUnknown(std::vector<std::string> known) const {
    known.insert(known.end(), std::begin(kKeplerianElements), std::end(kKeplerianElements));
    std::set<std::string> told;
    for (const pugi::xml_node& child : node_.children()) {
      if (child.type() != pugi::node_element) continue;
      if (std::find(known.begin(), known.end(), child.name()) != known.end()) continue;
      if (!told.insert(child.name()).second) continue;
      if (told.size() > kMaxChildren) {
        throw InputError(
            file_,
            "more than " + std::to_string(kMaxChildren) + " unknown elements in '" + name_ + "'",
            "a known one, for example '" + known.front() + "'");
      }
      LOG(WARNING) << file_ << ": element '" << name_ << "/" << child.name() << "' is not used";
    }
  }

 private:
  std::string file_;
  std::string name_;
  pugi::xml_node node_;
};

pugi::xml_document Parse(const std::string& path) {
  const std::string text = ReadTextFile(path);
  pugi::xml_document document;
  const pugi::xml_parse_result result = document.load_buffer(text.data(), text.size());
  if (!result) {
    throw InputError(
        path,
        "'" + std::string(result.description()) + "' at byte " + std::to_string(result.offset),
        "well-formed XML");
  }
  return document;
}

Element Root(const std::string& path, const pugi::xml_document& document, const char* name) {
  const std::string found = document.document_element().name();
  if (found != name) {
    throw InputError(path, "the root element '" + found + "'", "'" + std::string(name) + "'");
  }
  return {path, name, document.document_element()};
}

bool ParseBool(const Element& parent, const char* name, const std::string& path) {
  const std::string text = parent.Text(name);
  if (text == "true" || text == "1") return true;
  if (text == "false" || text == "0") return false;
  throw InputError(path, std::string(name) + " of '" + text + "'", "true or false");
}

std::optional<MicroLensMode> ModeOf(const Element& root, const std::string& path) {
  for (const char* name : kKeplerianElements) {
    if (!root.Has(name)) continue;
    return ParseBool(root, name, path) ? MicroLensMode::kKeplerian : MicroLensMode::kGalilean;
  }
  return std::nullopt;
}

double Angle(const Eigen::Vector2d& v) { return std::atan2(v.y(), v.x()); }

std::string XmlPair(const char* name, const Eigen::Vector2d& v) {
  std::ostringstream out;
  out.precision(15);
  out << "<" << name << "><x>" << v.x() << "</x><y>" << v.y() << "</y></" << name << ">";
  return out.str();
}

}  // namespace

PlenopticCamera ReadLifcalXml(const std::string& path) {
  const pugi::xml_document document = Parse(path);
  const Element root = Root(path, document, "Root");
  const std::string model = root.Text("CalibrationModel");
  if (model != "Plenoptic") {
    throw InputError(path, "the CalibrationModel '" + model + "'", "'Plenoptic'");
  }
  root.WarnOfUnknown({"CalibrationModel",
                      "ImageSize",
                      "PixelSize",
                      "PrincipalPoint",
                      "FocalLength",
                      "MainLensMlaDistance",
                      "SensorMlaDistance",
                      "RadialDistortion",
                      "TangentialDistortion",
                      "MicroLensCenterAdjustment"});
  PlenopticCamera camera;
  camera.focused_scale = kLifcalFocusedScale;
  const Element size = root.Child("ImageSize");
  camera.raw_width = ParsePixelCount(size.Number("Width"), path) * kLifcalFocusedScale;
  camera.raw_height = ParsePixelCount(size.Number("Height"), path) * kLifcalFocusedScale;
  camera.raw_pixel_size = 1e-3 * root.LengthMm("PixelSize");
  camera.raw_principal_point =
      (root.Vector("PrincipalPoint").array() + 0.5) * kLifcalFocusedScale - 0.5;
  camera.focal_length = 1e-3 * root.LengthMm("FocalLength");
  camera.main_lens_mla_distance = 1e-3 * root.LengthMm("MainLensMlaDistance");
  camera.sensor_mla_distance = 1e-3 * root.LengthMm("SensorMlaDistance");
  if (root.Has("RadialDistortion")) {
    const Element radial = root.Child("RadialDistortion");
    camera.distortion.A0 = 1e6 * radial.NumberOr("A0", 0);
    camera.distortion.A1 = 1e12 * radial.NumberOr("A1", 0);
  }
  if (root.Has("TangentialDistortion")) {
    const Element tangential = root.Child("TangentialDistortion");
    camera.distortion.B0 = 1e3 * tangential.NumberOr("B0", 0);
    camera.distortion.B1 = 1e3 * tangential.NumberOr("B1", 0);
  }
  if (root.Has("MicroLensCenterAdjustment")) {
    camera.adjust_micro_lens_centers = ParseBool(root, "MicroLensCenterAdjustment", path);
  }
  camera.mode = ModeOf(root, path).value_or(camera.mode);
  return camera;
}

std::string LifcalXml(const PlenopticCamera& camera) {
  CHECK_EQ(camera.focused_scale, kLifcalFocusedScale);
  const Eigen::Vector2d c = (camera.raw_principal_point.array() + 0.5) / kLifcalFocusedScale - 0.5;
  const Distortion& d = camera.distortion;
  std::ostringstream out;
  out.precision(15);
  out << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Root>\n"
      << "  <CalibrationModel>Plenoptic</CalibrationModel>\n"
      << "  <ImageSize units=\"pix\"><Width>" << camera.focused_width() << "</Width><Height>"
      << camera.focused_height() << "</Height></ImageSize>\n"
      << "  <PixelSize units=\"mm\">" << 1e3 * camera.raw_pixel_size << "</PixelSize>\n"
      << "  <PrincipalPoint units=\"pix\"><x>" << c.x() << "</x><y>" << c.y()
      << "</y></PrincipalPoint>\n"
      << "  <FocalLength units=\"mm\">" << 1e3 * camera.focal_length << "</FocalLength>\n"
      << "  <MainLensMlaDistance units=\"mm\">" << 1e3 * camera.main_lens_mla_distance
      << "</MainLensMlaDistance>\n"
      << "  <SensorMlaDistance units=\"mm\">" << 1e3 * camera.sensor_mla_distance
      << "</SensorMlaDistance>\n"
      << "  <RadialDistortion><A0>" << 1e-6 * d.A0 << "</A0><A1>" << 1e-12 * d.A1
      << "</A1></RadialDistortion>\n"
      << "  <TangentialDistortion><B0>" << 1e-3 * d.B0 << "</B0><B1>" << 1e-3 * d.B1
      << "</B1></TangentialDistortion>\n"
      << "  <MicroLensCenterAdjustment>" << (camera.adjust_micro_lens_centers ? "true" : "false")
      << "</MicroLensCenterAdjustment>\n"
      << "  <IsKepler>" << (camera.mode == MicroLensMode::kKeplerian ? "true" : "false")
      << "</IsKepler>\n</Root>\n";
  return out.str();
}

MicroLensGrid ReadRaytrixXml(const std::string& path, std::optional<MicroLensMode>* mode) {
  const pugi::xml_document document = Parse(path);
  const Element root = Root(path, document, "RayCalibData");
  root.WarnOfUnknown({"offset",
                      "diameter",
                      "rotation",
                      "lens_border",
                      "tcp",
                      "lens_base_x",
                      "lens_base_y",
                      "sub_grid_base",
                      "distortion",
                      "lens_type"});
  if (root.Has("distortion") && root.Child("distortion").Has("function") &&
      root.Child("distortion").Text("function") != "constant") {
    LOG(WARNING) << path << ": the grid's distortion is not used; give it in the camera file";
  }
  *mode = ModeOf(root, path);
  MicroLensGrid grid;
  grid.offset_px = root.Vector("offset");
  grid.diameter_px = root.Number("diameter");
  grid.base_x = root.Vector("lens_base_x");
  grid.base_y = root.Vector("lens_base_y");
  grid.rotation = root.Number("rotation");
  const double beyond_base = std::remainder(grid.rotation - Angle(grid.base_x), 2 * M_PI);
  if (std::abs(beyond_base) < kRotationInBaseVectors) grid.rotation = beyond_base;
  grid.lens_border_px = root.NumberOr("lens_border", grid.lens_border_px);
  grid.total_covering_plane = root.NumberOr("tcp", grid.total_covering_plane);
  const std::vector<Element> types = root.Children("lens_type");
  if (!types.empty()) grid.types.clear();
  for (const Element& element : types) {
    MicroLensType type;
    type.offset = element.Vector("offset");
    type.min_virtual_depth = element.Child("depth_range").Number("min");
    type.max_virtual_depth = element.Child("depth_range").Number("max");
    grid.types.push_back(type);
  }
  return grid;
}

std::string RaytrixXml(const MicroLensGrid& grid) {
  const Eigen::Rotation2Dd rotation(grid.rotation);
  const Eigen::Vector2d base_x = rotation * grid.base_x;
  std::ostringstream out;
  out.precision(15);
  out << "<?xml version=\"1.0\"?>\n<RayCalibData version=\"1.0\">\n"
      << "  " << XmlPair("offset", grid.offset_px) << "\n"
      << "  <diameter>" << grid.diameter_px << "</diameter>\n"
      << "  <rotation>" << Angle(base_x) << "</rotation>\n"
      << "  <lens_border>" << grid.lens_border_px << "</lens_border>\n"
      << "  <tcp>" << grid.total_covering_plane << "</tcp>\n"
      << "  " << XmlPair("lens_base_x", base_x) << "\n"
      << "  " << XmlPair("lens_base_y", rotation * grid.base_y) << "\n"
      << "  " << XmlPair("sub_grid_base", {3, 1}) << "\n";
  for (size_t i = 0; i < grid.types.size(); ++i) {
    const MicroLensType& type = grid.types[i];
    out << "  <lens_type id=\"" << i << "\">" << XmlPair("offset", rotation * type.offset)
        << "<depth_range><min>" << type.min_virtual_depth << "</min><max>" << type.max_virtual_depth
        << "</max></depth_range></lens_type>\n";
  }
  out << "</RayCalibData>\n";
  return out.str();
}

}  // namespace prism
