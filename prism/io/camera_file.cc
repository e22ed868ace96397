// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/camera_file.h"

#include <filesystem>
#include <optional>
#include <sstream>
#include <vector>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"
#include "prism/io/camera_number.h"
#include "prism/io/camera_plausibility.h"
#include "prism/io/camera_xml.h"
#include "prism/io/camera_yaml.h"

namespace prism {
namespace {

constexpr char kFormats[] = "a .yaml (native), .xml (LiFCal or Raytrix) or .txt (pinhole) file";

bool IsYaml(const std::string& extension) { return extension == ".yaml" || extension == ".yml"; }

PinholeCamera ReadPinholeText(const std::string& path) {
  constexpr char kExpected[] = "one line 'fx fy cx cy width height' in px";
  const std::string contents = ReadTextFile(path);
  if (contents.find('\0') != std::string::npos) throw InputError(path, "a binary file", kExpected);
  std::istringstream lines(contents);
  std::vector<double> numbers;
  std::string line;
  while (std::getline(lines, line)) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string word;
    while (words >> word) numbers.push_back(ParseCameraNumber(word, path, kExpected));
  }
  if (numbers.size() != 6) {
    throw InputError(path, std::to_string(numbers.size()) + " numbers", kExpected);
  }
  PinholeCamera camera;
  camera.fx = numbers[0];
  camera.fy = numbers[1];
  camera.cx = numbers[2];
  camera.cy = numbers[3];
  camera.width = ParsePixelCount(numbers[4], path);
  camera.height = ParsePixelCount(numbers[5], path);
  return camera;
}

// Says "FOUND, expected EXPECTED" as IsValid does.
[[noreturn]] void ThrowInvalid(const std::string& path, const std::string& error) {
  const std::string separator = ", expected ";
  const size_t split = error.find(separator);
  if (split == std::string::npos) throw InputError(path, error, "figures of a real camera");
  throw InputError(path, error.substr(0, split), error.substr(split + separator.size()));
}

template <typename T>
void RequireValid(const T& object, const std::string& path) {
  std::string error;
  if (!object.IsValid(&error)) ThrowInvalid(path, error);
}

MicroLensGrid ReadGridAndMode(const std::string& path, std::optional<MicroLensMode>* mode) {
  const std::string extension = std::filesystem::path(path).extension().string();
  if (IsYaml(extension)) {
    const PlenopticCamera camera = ReadPlenopticCamera(path);
    if (!camera.micro_lens_grid) {
      throw InputError(path, "no micro_lens_grid", "a camera with a micro_lens_grid");
    }
    *mode = camera.mode;
    return *camera.micro_lens_grid;
  }
  if (extension != ".xml") throw InputError(path, "the extension '" + extension + "'", kFormats);
  MicroLensGrid grid = ReadRaytrixXml(path, mode);
  RequireValid(grid, path);
  RequirePlausibleGrid(grid, path);
  return grid;
}

}  // namespace

AnyCamera ReadCamera(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  AnyCamera camera;
  if (IsYaml(extension)) {
    camera = ReadCameraYaml(path);
  } else if (extension == ".xml") {
    camera = ReadLifcalXml(path);
  } else if (extension == ".txt") {
    camera = ReadPinholeText(path);
  } else {
    throw InputError(path, "the extension '" + extension + "'", kFormats);
  }
  std::visit([&](const auto& c) { RequireValid(c, path); }, camera);
  if (const auto* plenoptic = std::get_if<PlenopticCamera>(&camera)) {
    RequirePlausibleCamera(*plenoptic, path);
  } else {
    RequirePlausiblePinhole(std::get<PinholeCamera>(camera), path);
  }
  return camera;
}

PlenopticCamera ReadPlenopticCamera(const std::string& path) {
  const AnyCamera camera = ReadCamera(path);
  if (const auto* plenoptic = std::get_if<PlenopticCamera>(&camera)) return *plenoptic;
  throw InputError(path, "a pinhole camera", "a plenoptic camera");
}

PinholeCamera ReadPinholeCamera(const std::string& path) {
  const AnyCamera camera = ReadCamera(path);
  if (const auto* pinhole = std::get_if<PinholeCamera>(&camera)) return *pinhole;
  throw InputError(path, "a plenoptic camera", "a pinhole camera");
}

PlenopticCamera ReadMetricCamera(const std::string& path) {
  PlenopticCamera camera = ReadPlenopticCamera(path);
  RequireMetricDepth(camera, path);
  return camera;
}

MicroLensGrid ReadMicroLensGrid(const std::string& path) {
  std::optional<MicroLensMode> mode;
  return ReadGridAndMode(path, &mode);
}

void AddMicroLensGrid(const std::string& path, PlenopticCamera* camera) {
  std::optional<MicroLensMode> mode;
  camera->micro_lens_grid = ReadGridAndMode(path, &mode);
  camera->mode = mode.value_or(camera->mode);
}

void RequireMetricDepth(const PlenopticCamera& camera, const std::string& path) {
  std::string error;
  if (!camera.HasMetricDepth(&error)) ThrowInvalid(path, error);
  RequirePlausibleInfinity(camera, path);
}

void WriteNativeCamera(const std::string& path, const AnyCamera& camera) {
  WriteTextAtomically(path, std::visit([](const auto& c) { return CameraYaml(c); }, camera));
}

void WriteLifcalCamera(const std::string& path, const PlenopticCamera& camera) {
  WriteTextAtomically(path, LifcalXml(camera));
}

void WriteRaytrixGrid(const std::string& path, const MicroLensGrid& grid) {
  WriteTextAtomically(path, RaytrixXml(grid));
}

}  // namespace prism
