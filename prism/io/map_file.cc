// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/map_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include <opencv2/core/persistence.hpp>
#include <opencv2/imgcodecs.hpp>

#include "prism/base/error.h"
#include "prism/base/statistics.h"
#include "prism/io/atomic_file.h"
#include "prism/io/image_file.h"

namespace prism {
namespace {

constexpr const char* kFormat = "prism_map";
constexpr int kVirtualPoints = 1, kChiefRays = 2;  // versions
constexpr int kDescriptorSize = 32;

std::string ImageName(int id) {
  char name[32];
  std::snprintf(name, sizeof(name), "images/%06d.jpg", id);
  return name;
}

// OpenCV's parser does not come to an end on some tags. The only one written is a matrix's.
bool HasForeignTags(const std::string& text) {
  const std::string tag = "!!opencv-matrix";
  for (size_t at = text.find('!'); at != std::string::npos; at = text.find('!', at + tag.size())) {
    if (text.compare(at, tag.size(), tag) != 0) return true;
  }
  return false;
}

void WritePlace(const MappedPlace& known, cv::FileStorage* file) {
  const Place& place = known.place;
  cv::Mat points(static_cast<int>(place.points.size()), 4, CV_32F);
  for (int i = 0; i < points.rows; ++i) {
    const Place::Point& point = place.points[i];
    const float row[] = {point.x, point.y, point.rho, point.rho_sigma};
    std::copy_n(row, 4, points.ptr<float>(i));
  }
  cv::Mat features(static_cast<int>(place.features.size()), 3, CV_32F);
  for (int i = 0; i < features.rows; ++i) {
    const Place::Feature& feature = place.features[i];
    const float row[] = {feature.x, feature.y, feature.rho};
    std::copy_n(row, 3, features.ptr<float>(i));
  }
  cv::Mat pose(1, 7, CV_64F);
  std::copy_n(known.cam_from_world.data(), 7, pose.ptr<double>());
  *file << "{"
        << "id" << place.keyframe_id << "time_ns" << std::to_string(known.time_ns) << "image"
        << ImageName(place.keyframe_id) << "cam_from_world" << pose << "points" << points
        << "features" << features << "descriptors" << place.descriptors << "}";
}

int VersionOf(const PlenopticProjection& camera) {
  return camera.image == FocusedImage::kChiefRays ? kChiefRays : kVirtualPoints;
}

// Reads the nodes of one file; everything throws InputError.
class MapReader {
 public:
  explicit MapReader(const std::string& folder)
      : folder_(folder), path_(InFolder(folder, "map.yml")) {
    if (!IsFile(path_)) {
      throw InputError(path_, "no such file", "a map of prism_vo --save_map");
    }
    const std::string text = ReadTextFile(path_);
    try {
      if (!HasForeignTags(text)) {
        file_.open(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
      }
    } catch (const std::exception&) {
    }
    std::string format;
    if (file_.isOpened()) file_["format"] >> format;
    if (format != kFormat) throw InputError(path_, "a file of another format", kFormat);
    version_ = Integer(file_.root(), "version");
    if (version_ != kVirtualPoints && version_ != kChiefRays) {
      throw InputError(path_, "version " + std::to_string(version_), "version 1 or 2");
    }
  }

  void RequireCamera(const PlenopticProjection& camera) const {
    const cv::FileNode node = file_["camera"];
    const int width = Integer(node, "focused_width_px");
    const int height = Integer(node, "focused_height_px");
    const double f_px = Real(node, "focal_length_px");
    const Eigen::Vector2d c(Real(node, "principal_point_x_px"), Real(node, "principal_point_y_px"));
    if (version_ != VersionOf(camera)) {
      throw InputError(path_,
                       version_ == kChiefRays ? "images of chief rays" : "images of virtual points",
                       "images as this run's (prism_vo --focused_image)");
    }
    constexpr double kTolerance = 0.01;
    if (width == camera.width && height == camera.height &&
        std::abs(f_px / camera.FocalLengthPx() - 1) <= kTolerance &&
        (c - camera.c).norm() <= kTolerance * width) {
      return;
    }
    const auto text = [](int w, int h, double f, const Eigen::Vector2d& center) {
      char line[128];
      std::snprintf(line,
                    sizeof(line),
                    "%d x %d px, f %.1f px, centre %.1f %.1f",
                    w,
                    h,
                    f,
                    center.x(),
                    center.y());
      return std::string(line);
    };
    throw InputError(path_,
                     "places of a camera of " + text(width, height, f_px, c),
                     "one like this run's, " +
                         text(camera.width, camera.height, camera.FocalLengthPx(), camera.c));
  }

  std::vector<MappedPlace> Places(int width, int height) const {
    std::vector<MappedPlace> places;
    std::set<int> ids;
    for (const cv::FileNode& node : file_["places"]) {
      places.push_back(ReadPlace(node, width, height));
      if (!ids.insert(places.back().place.keyframe_id).second) {
        throw InputError(path_,
                         "two places of id " + std::to_string(places.back().place.keyframe_id),
                         "one of each");
      }
    }
    if (places.empty()) throw InputError(path_, "no place", "one or more");
    return places;
  }

 private:
  MappedPlace ReadPlace(const cv::FileNode& node, int width, int height) const {
    MappedPlace known;
    Place& place = known.place;
    place.keyframe_id = Integer(node, "id");
    if (place.keyframe_id < 0) throw InputError(path_, "a negative id", "0 or more");
    known.time_ns = std::strtoll(Text(node, "time_ns").c_str(), nullptr, 10);
    const cv::Mat pose = Matrix(node, "cam_from_world", CV_64F, 7);
    if (pose.rows != 1 || std::abs(cv::norm(pose.colRange(0, 4)) - 1) > 1e-6) {
      throw InputError(path_, "'cam_from_world' that is no pose", "a unit quaternion, a position");
    }
    known.cam_from_world = SE3(pose.ptr<double>());
    const cv::Mat points = Matrix(node, "points", CV_32F, 4);
    std::vector<double> rho;
    for (int i = 0; i < points.rows; ++i) {
      const float* row = points.ptr<float>(i);
      if (row[2] < 0 || row[3] < 0) throw InputError(path_, "a negative depth", "0 or more");
      place.points.push_back({row[0], row[1], row[2], row[3]});
      rho.push_back(row[2]);
    }
    place.median_rho = static_cast<float>(Quantile(rho, 0.5));
    const cv::Mat features = Matrix(node, "features", CV_32F, 3);
    for (int i = 0; i < features.rows; ++i) {
      const float* row = features.ptr<float>(i);
      place.features.push_back({row[0], row[1], row[2]});
    }
    place.descriptors = Matrix(node, "descriptors", CV_8U, kDescriptorSize);
    if (place.descriptors.rows != features.rows) {
      throw InputError(path_,
                       std::to_string(place.descriptors.rows) + " descriptors of " +
                           std::to_string(features.rows) + " features",
                       "one each");
    }
    const std::string image_path = InFolder(folder_, Text(node, "image"));
    ReadGrayImage(image_path, width, height);  // it is as it should be
    const std::string bytes = ReadTextFile(image_path);
    place.image.assign(bytes.begin(), bytes.end());
    return known;
  }

  cv::FileNode Get(const cv::FileNode& node,
                   const char* key,
                   bool is_of_type(const cv::FileNode&)) const {
    const cv::FileNode value = node.isMap() ? node[key] : cv::FileNode();
    if (value.empty() || !is_of_type(value)) {
      throw InputError(path_, "no '" + std::string(key) + "' that can be read", "a map's");
    }
    return value;
  }
  int Integer(const cv::FileNode& node, const char* key) const {
    return static_cast<int>(
        Get(node, key, [](const cv::FileNode& value) { return value.isInt(); }));
  }
  double Real(const cv::FileNode& node, const char* key) const {
    return static_cast<double>(
        Get(node, key, [](const cv::FileNode& value) { return value.isReal() || value.isInt(); }));
  }
  std::string Text(const cv::FileNode& node, const char* key) const {
    return static_cast<std::string>(
        Get(node, key, [](const cv::FileNode& value) { return value.isString(); }));
  }
  // Of finite numbers; may have no rows.
  cv::Mat Matrix(const cv::FileNode& node, const char* key, int type, int columns) const {
    cv::Mat matrix;
    try {
      // Memory for it is taken before the data are read; a size that is a text counts as 2^31 - 1.
      constexpr int kMaxSide = 1000000;
      const cv::FileNode header =
          Get(node, key, [](const cv::FileNode& value) { return value.isMap(); });
      for (const char* side : {"rows", "cols"}) {
        if (!header[side].isInt() || static_cast<int>(header[side]) > kMaxSide) {
          throw InputError(path_,
                           "'" + std::string(key) + "' without '" + side + "' or with too many",
                           "up to " + std::to_string(kMaxSide));
        }
      }
      Get(node, key, [](const cv::FileNode& value) { return value.isMap(); }) >> matrix;
    } catch (const cv::Exception&) {
      matrix = cv::Mat(1, 1, CV_16S);  // of no type that is asked for
    }
    if (matrix.empty()) return cv::Mat(0, columns, type);
    if (matrix.type() != type || matrix.cols != columns || matrix.dims != 2 ||
        !cv::checkRange(matrix)) {
      throw InputError(path_,
                       "'" + std::string(key) + "' that is no matrix of finite numbers",
                       std::to_string(columns) + " columns");
    }
    return matrix;
  }

  std::string folder_;
  std::string path_;
  cv::FileStorage file_;
  int version_ = 0;
};

}  // namespace

void WriteMap(const std::string& folder,
              const PlenopticProjection& camera,
              const std::vector<MappedPlace>& places) {
  CreateDirectory(InFolder(folder, "images"));
  cv::FileStorage file("map.yml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  file << "format" << kFormat << "version" << VersionOf(camera);
  file << "camera"
       << "{"
       << "focused_width_px" << camera.width << "focused_height_px" << camera.height
       << "focal_length_px" << camera.FocalLengthPx() << "principal_point_x_px" << camera.c.x()
       << "principal_point_y_px" << camera.c.y() << "}";
  file << "places"
       << "[";
  for (const MappedPlace& known : places) {
    WriteTextAtomically(InFolder(folder, ImageName(known.place.keyframe_id)),
                        std::string(known.place.image.begin(), known.place.image.end()));
    WritePlace(known, &file);
  }
  file << "]";
  WriteTextAtomically(InFolder(folder, "map.yml"), file.releaseAndGetString());
}

std::vector<MappedPlace> ReadMap(const std::string& folder, const PlenopticProjection& camera) {
  try {
    const MapReader reader(folder);
    reader.RequireCamera(camera);
    return reader.Places(camera.width, camera.height);
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& error) {  // OpenCV's parser has many ways to fail
    throw InputError(InFolder(folder, "map.yml"), "'" + std::string(error.what()) + "'", kFormat);
  }
}

}  // namespace prism
