// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// Every figure of a camera file at and beyond its limits: a camera that can be, or one line that
// names file and figure.
#include <chrono>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"
#include "prism/io/camera_file.h"
#include "test/io/rgbd_folder.h"

namespace prism {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr char kYaml[] = R"(model: plenoptic
mode: galilean
image_size_px: [2048, 2048]
pixel_size_mm: 0.0055
focal_length_mm: 16.748
main_lens_mla_distance_mm: 15.893
sensor_mla_distance_mm: 0.376
principal_point_px: [1018.7, 1054.2]
focused_scale: 2
micro_lens_grid:
  diameter_px: 23.2
  rotation_rad: 0.001
  offset_px: [0, 0]
  base_x: [1, 0]
  base_y: [0.5, 0.8660254]
  lens_border_px: 1
  total_covering_plane: 2.2
  lens_types:
    - {offset: [0, 0], virtual_depth_range: [1, 100]}
)";

// What stands in place of the value of a key, and the figure that the error names; nothing: the
// file is read.
struct FigureFault {
  std::string key, value, named;
};

std::string WithValue(const FigureFault& fault) {
  std::string text = kYaml;
  const size_t begin = text.find(" " + fault.key + ":") == std::string::npos
                           ? text.find("\n" + fault.key + ":") + 1
                           : text.find(" " + fault.key + ":") + 1;
  const size_t value = begin + fault.key.size() + 2;
  return text.replace(value, text.find('\n', value) - value, fault.value);
}

std::string ErrorOf(const std::string& path) {
  try {
    ReadMetricCamera(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(FigureFaults, OfYamlAreNamed) {
  const std::string path = FreshFolder("figures") + "/camera.yaml";
  const std::vector<FigureFault> faults = {
      {"focal_length_mm", "16.748", ""},
      {"focal_length_mm", "0.016748", "a focal length of 0.016748 mm"},
      {"focal_length_mm", "16748", "a focal length of 16748 mm"},
      {"focal_length_mm", "60", "a virtual depth of infinity"},
      {"focal_length_mm", "16.0", "a virtual depth of infinity"},
      {"focal_length_mm", "15", "more than the distance from main lens to MLA"},
      {"pixel_size_mm", "5.5", "a pixel size of 5.5 mm"},
      {"pixel_size_mm", "0.0000055", "a pixel size of 5.5e-06 mm"},
      {"pixel_size_mm", "0.055", "a field of view of 1"},
      {"pixel_size_mm", "0.0004", "a field of view of 3.98"},
      {"principal_point_px", "[-3, 1024]", "a principal point x of -3 px"},
      {"principal_point_px", "[1024, 5000]", "a principal point y of 5000 px"},
      {"principal_point_px", "[0.005, 1e300]", "a principal point y of 1e+300 px"},
      {"sensor_mla_distance_mm", "0.04", "a distance from sensor to MLA"},
      {"sensor_mla_distance_mm", "5", "a distance from sensor to MLA"},
      {"main_lens_mla_distance_mm", "0.015893", "a field of view"},
      {"diameter_px", "0", "micro-image diameter of 0"},
      {"diameter_px", "1e9", "a micro-image diameter of 1e+09 px"},
      {"diameter_px", "2320", "a micro-image diameter of 2320 px"},
      {"offset_px", "[1e14, 0]", "a grid offset of 1e+14 px"},
      {"lens_border_px", "-1e9", "a lens border of -1e+09 px"},
      {"lens_border_px", "20", "a lens border of 20 px"},
      {"rotation_rad", "90", "a grid rotation of 90 rad"},
      {"total_covering_plane", "-2", "a total covering plane of -2"},
      {"base_x", "[0, 0]", "parallel base vectors"},
      {"base_x", "[1e9, 0]", "a base vector's length of 1e+09"},
      {"image_size_px", "[1e9, 2048]", "an image side of 1e+09 px"},
      {"image_size_px", "[-5, 2048]", "an image side of -5 px"},
      {"image_size_px", "[0, 0]", "image width of 0"},
      {"focused_scale", "0", "focused scale of 0"},
      {"focused_scale", "1000", "focused scale of 1000"},
      {"mode", "lytro", "the mode 'lytro'"},
      {"model", "camera", "the model 'camera'"},
  };
  for (const FigureFault& fault : faults) {
    SCOPED_TRACE(fault.key + ": " + fault.value);
    WriteFile(path, WithValue(fault));
    const std::string error = ErrorOf(path);
    if (fault.named.empty()) {
      EXPECT_EQ(error, "");
      continue;
    }
    EXPECT_THAT(
        error,
        AllOf(HasSubstr(path + ": found "), HasSubstr(", expected "), HasSubstr(fault.named)));
  }
}

TEST(FigureFaults, EveryKeyRefusesWhatIsNoNumber) {
  const std::string path = FreshFolder("figures") + "/camera.yaml";
  for (const char* key : {"image_size_px",
                          "pixel_size_mm",
                          "focal_length_mm",
                          "main_lens_mla_distance_mm",
                          "sensor_mla_distance_mm",
                          "principal_point_px",
                          "focused_scale",
                          "diameter_px",
                          "rotation_rad",
                          "offset_px",
                          "base_x",
                          "base_y",
                          "lens_border_px",
                          "total_covering_plane"}) {
    for (const char* value : {".nan",
                              ".inf",
                              "-.inf",
                              "big",
                              "",
                              "[]",
                              "{a: 1}",
                              "1e999",
                              "[.nan, .nan]",
                              "[1, 2, 3]"}) {
      WriteFile(path, WithValue({key, value, ""}));
      EXPECT_THAT(ErrorOf(path), AllOf(HasSubstr(path), HasSubstr(", expected ")))
          << key << ": " << value;
    }
  }
}

TEST(FigureFaults, OfYamlAsAWholeAreNamed) {
  const std::string path = FreshFolder("figures") + "/camera.yaml";
  const auto error_with = [&](const std::string& text) {
    WriteFile(path, text);
    return ErrorOf(path);
  };
  EXPECT_THAT(error_with(std::string(kYaml) + "focal_length_mm: 16\n"),
              HasSubstr("the key 'focal_length_mm' twice"));
  EXPECT_THAT(
      error_with(WithValue({"lens_types", "[{offset: [0, 0], virtual_depth_range: [-5, 3]}]", ""})
                     .substr(0, std::string(kYaml).find("  lens_types")) +
                 "  lens_types: [{offset: [0, 0], virtual_depth_range: [-5, 3]}]\n"),
      HasSubstr("a smallest virtual depth of -5"));
  EXPECT_THAT(error_with(std::string(kYaml).substr(0, std::string(kYaml).find("  lens_types")) +
                         "  lens_types: [{offset: [0, 0], virtual_depth_range: [3, 2]}]\n"),
              HasSubstr("a largest virtual depth of 2"));
  EXPECT_THAT(error_with("? [a, b]\n: 3\n"), HasSubstr(path));
  EXPECT_THAT(error_with(std::string(100000, '[')), HasSubstr(path));
}

std::string Xml(const std::string& lengths) {
  return "<Root><CalibrationModel>Plenoptic</CalibrationModel><ImageSize><Width>1024</Width>"
         "<Height>1024</Height></ImageSize><PrincipalPoint><x>510</x><y>512</y></PrincipalPoint>" +
         lengths + "<SensorMlaDistance>0.376</SensorMlaDistance></Root>";
}

TEST(FigureFaults, UnitsOfXmlCount) {
  const std::string path = FreshFolder("figures") + "/camera.xml";
  const auto error_with = [&](const std::string& text) {
    WriteFile(path, text);
    return ErrorOf(path);
  };
  EXPECT_EQ(error_with(Xml("<PixelSize units=\"um\">5.5</PixelSize><FocalLength units=\"cm\">1.6748"
                           "</FocalLength><MainLensMlaDistance units=\"m\">0.015893"
                           "</MainLensMlaDistance>")),
            "");
  const PlenopticCamera camera = ReadPlenopticCamera(path);
  EXPECT_NEAR(camera.raw_pixel_size, 5.5e-6, 1e-15);
  EXPECT_NEAR(camera.focal_length, 16.748e-3, 1e-12);
  EXPECT_NEAR(camera.main_lens_mla_distance, 15.893e-3, 1e-12);
  EXPECT_THAT(error_with(Xml("<PixelSize units=\"inch\">5.5</PixelSize>")), HasSubstr("in 'inch'"));
}

TEST(FigureFaults, XmlOfMillionsOfElementsIsRefusedAtOnce) {
  const std::string path = FreshFolder("figures") + "/camera.xml";
  std::string many = "<PixelSize>0.0055</PixelSize>";
  for (int i = 0; i < 2500000; ++i) many += "<a" + std::to_string(i) + "/>";
  WriteFile(path, Xml(many));
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THAT(ErrorOf(path), HasSubstr("unknown elements in 'Root'"));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
  many.clear();
  for (int i = 0; i < 100; ++i) many += "<lens_type/>";
  WriteFile(path,
            "<RayCalibData><offset><x>0</x><y>0</y></offset><diameter>23</diameter>"
            "<rotation>0</rotation><lens_base_x><x>1</x><y>0</y></lens_base_x>"
            "<lens_base_y><x>0.5</x><y>0.87</y></lens_base_y>" +
                many + "</RayCalibData>");
  EXPECT_THROW(ReadMicroLensGrid(path), InputError);
}

}  // namespace
}  // namespace prism
