// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/camera_file.h"

#include <filesystem>

#include <glog/logging.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"

namespace prism {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const char kRaytrixR5[] = R"(<RayCalibData version="1.0">
  <offset units="pix"><x>13.04</x><y>-20.3</y></offset>
  <diameter units="pix">23.2023</diameter>
  <rotation units="rad">1.570796370506</rotation>
  <lens_border>1.0</lens_border><tcp>2.2</tcp>
  <lens_base_x units="lens"><x>-4.3711e-008</x><y>1.0</y></lens_base_x>
  <lens_base_y units="lens"><x>0.866025388241</x><y>0.500000059605</y></lens_base_y>
  <sub_grid_base units="lens"><x>1.73</x><y>3.0</y></sub_grid_base>
  <distortion type="radial"><function>constant</function></distortion>
  <lens_type id="0"><offset><x>0</x><y>0</y></offset>
    <depth_range><min>1</min><max>3.2</max></depth_range></lens_type>
  <lens_type id="1"><offset><x>0</x><y>1</y></offset>
    <depth_range><min>2.6</min><max>4.2</max></depth_range></lens_type>
  <lens_type id="2"><offset><x>0</x><y>-1</y></offset>
    <depth_range><min>3.5</min><max>100</max></depth_range></lens_type>
</RayCalibData>)";

class CameraFileTest : public testing::Test {
 protected:
  CameraFileTest() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = testing::TempDir() + "camera_file_test_" + test->name();
    CreateDirectory(folder_);
  }
  ~CameraFileTest() override { std::filesystem::remove_all(folder_); }

  std::string Path(const std::string& name) const { return folder_ + "/" + name; }

  std::string Write(const std::string& name, const std::string& text) const {
    WriteTextAtomically(Path(name), text);
    return Path(name);
  }

  // The message of the InputError that `read` throws.
  template <typename Function>
  static std::string ErrorOf(Function read) {
    try {
      read();
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  std::string folder_;
};

std::string Calibration(const std::string& name) {
  return std::string(PRISM_SOURCE_DIR) + "/calib/" + name;
}

std::string Replace(std::string text, const std::string& from, const std::string& to) {
  const size_t position = text.find(from);
  CHECK_NE(position, std::string::npos) << from;
  return text.replace(position, from.size(), to);
}

void ExpectSameCamera(const PlenopticCamera& a, const PlenopticCamera& b) {
  EXPECT_NEAR(a.focal_length, b.focal_length, 1e-15);
  EXPECT_NEAR(a.main_lens_mla_distance, b.main_lens_mla_distance, 1e-15);
  EXPECT_NEAR(a.sensor_mla_distance, b.sensor_mla_distance, 1e-15);
  EXPECT_NEAR(a.raw_pixel_size, b.raw_pixel_size, 1e-18);
  EXPECT_EQ(a.raw_width, b.raw_width);
  EXPECT_EQ(a.raw_height, b.raw_height);
  EXPECT_EQ(a.focused_scale, b.focused_scale);
  EXPECT_LT((a.raw_principal_point - b.raw_principal_point).norm(), 1e-11);
  EXPECT_NEAR(a.distortion.A0, b.distortion.A0, 1e-13 * std::abs(a.distortion.A0));
  EXPECT_NEAR(a.distortion.A1, b.distortion.A1, 1e-13 * std::abs(a.distortion.A1));
  EXPECT_NEAR(a.distortion.B0, b.distortion.B0, 1e-13 * std::abs(a.distortion.B0));
  EXPECT_NEAR(a.distortion.B1, b.distortion.B1, 1e-13 * std::abs(a.distortion.B1));
  EXPECT_EQ(a.adjust_micro_lens_centers, b.adjust_micro_lens_centers);
  EXPECT_EQ(a.mode, b.mode);
}

// Same centre and same type at every lens that an image of 2048 x 2048 holds.
void ExpectSameLattice(const MicroLensGrid& a, const MicroLensGrid& b) {
  for (int j = -60; j <= 60; ++j) {
    for (int i = -60; i <= 60; ++i) {
      const LensIndex lens{i, j};
      ASSERT_LT(
          (a.MicroImageCenter(lens, 2048, 2048) - b.MicroImageCenter(lens, 2048, 2048)).norm(),
          1e-9)
          << i << " " << j;
      ASSERT_EQ(a.TypeOf(lens), b.TypeOf(lens)) << i << " " << j;
    }
  }
}

PlenopticCamera DistortedCamera() {
  PlenopticCamera camera = ReadPlenopticCamera(Calibration("raytrix_r5_35mm.yaml"));
  camera.mode = MicroLensMode::kKeplerian;
  camera.distortion = {21.0, -3e4, 0.02, -0.03};
  camera.adjust_micro_lens_centers = false;
  camera.micro_lens_grid->rotation = 0.0123;
  camera.micro_lens_grid->offset_px = {3.25, -7.5};
  return camera;
}

TEST_F(CameraFileTest, EveryShippedCameraLoads) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(Calibration(""))) {
    if (entry.path().extension() != ".yaml") continue;
    SCOPED_TRACE(entry.path().string());
    const PlenopticCamera camera = ReadPlenopticCamera(entry.path().string());
    EXPECT_TRUE(camera.micro_lens_grid.has_value());
    ++count;
  }
  EXPECT_GE(count, 3);
}

TEST_F(CameraFileTest, MillimetresBecomeMetres) {
  const PlenopticCamera camera = ReadPlenopticCamera(Calibration("raytrix_r5_16mm.yaml"));
  EXPECT_DOUBLE_EQ(camera.focal_length, 0.016748);
  EXPECT_DOUBLE_EQ(camera.main_lens_mla_distance, 0.015893);
  EXPECT_DOUBLE_EQ(camera.sensor_mla_distance, 0.000376);
  EXPECT_DOUBLE_EQ(camera.raw_pixel_size, 5.5e-6);
  EXPECT_EQ(camera.raw_principal_point, Eigen::Vector2d(1018.7, 1054.2));
}

TEST_F(CameraFileTest, DistortionCoefficientsArePerMillimetreInFiles) {
  const std::string path = Write("camera.yaml",
                                 ReadTextFile(Calibration("raytrix_r5_16mm.yaml")) +
                                     "distortion: {A0_per_mm2: 2e-5, B1_per_mm: 3e-4}\n");
  const Distortion distortion = ReadPlenopticCamera(path).distortion;
  // At r = 2 mm the radial shift is x A0 r^2.
  const Eigen::Vector2d shift = distortion.Distort({2e-3, 0}) - Eigen::Vector2d(2e-3, 0);
  EXPECT_NEAR(shift.x(), 1e-3 * 2 * 2e-5 * 4, 1e-12);
  EXPECT_NEAR(shift.y(), 1e-3 * 3e-4 * 4, 1e-12);
}

TEST_F(CameraFileTest, NativeRoundTrip) {
  const PlenopticCamera camera = DistortedCamera();
  WriteNativeCamera(Path("camera.yaml"), camera);
  const PlenopticCamera again = ReadPlenopticCamera(Path("camera.yaml"));
  ExpectSameCamera(camera, again);
  ExpectSameLattice(*camera.micro_lens_grid, *again.micro_lens_grid);
  EXPECT_EQ(again.micro_lens_grid->types[1].max_virtual_depth, 4.2);

  const PinholeCamera pinhole{640, 480, 525, 524, 319.5, 239.25};
  WriteNativeCamera(Path("pinhole.yaml"), pinhole);
  const PinholeCamera pinhole_again = ReadPinholeCamera(Path("pinhole.yaml"));
  EXPECT_EQ(pinhole_again.width, 640);
  EXPECT_EQ(pinhole_again.fy, 524);
  EXPECT_EQ(pinhole_again.cy, 239.25);
}

TEST_F(CameraFileTest, LifcalRoundTrip) {
  const PlenopticCamera camera = DistortedCamera();
  WriteLifcalCamera(Path("CameraModel.xml"), camera);
  ExpectSameCamera(camera, ReadPlenopticCamera(Path("CameraModel.xml")));
}

TEST_F(CameraFileTest, LifcalFilesCountInFocusedPixelsOfRawPixelSize) {
  WriteLifcalCamera(Path("CameraModel.xml"),
                    ReadPlenopticCamera(Calibration("raytrix_r5_16mm.yaml")));
  const std::string text = ReadTextFile(Path("CameraModel.xml"));
  EXPECT_THAT(text, HasSubstr("<Width>1024</Width>"));
  EXPECT_THAT(text, HasSubstr("<x>509.1<"));  // (1018.7 + 0.5) / 2 - 0.5
  EXPECT_THAT(text, HasSubstr("<PixelSize units=\"mm\">0.0055<"));
}

TEST_F(CameraFileTest, RaytrixRotationInTheBaseVectorsIsNotAppliedAgain) {
  const MicroLensGrid grid = ReadMicroLensGrid(Write("MLA_Calibration.xml", kRaytrixR5));
  EXPECT_LT(std::abs(grid.rotation), 1e-6);
  EXPECT_DOUBLE_EQ(grid.base_x.x(), -4.3711e-008);
  EXPECT_EQ(grid.types.size(), 3u);
  // Columns: the next lens along base_x is one diameter up, that is towards smaller rows.
  const Eigen::Vector2d origin = grid.MicroImageCenter({0, 0}, 2048, 2048);
  const Eigen::Vector2d next = grid.MicroImageCenter({1, 0}, 2048, 2048);
  EXPECT_LT((origin - Eigen::Vector2d(1023.5 + 13.04, 1023.5 + 20.3)).norm(), 1e-9);
  EXPECT_LT((next - origin - Eigen::Vector2d(0, -23.2023)).norm(), 1e-4);
}

TEST_F(CameraFileTest, RaytrixRotationBeyondTheBaseVectorsIsApplied) {
  const std::string small = Replace(kRaytrixR5, "1.570796370506", "1.5721");
  EXPECT_NEAR(ReadMicroLensGrid(Write("a.xml", small)).rotation, 1.5721 - M_PI / 2, 1e-6);
  const std::string all = Replace(kRaytrixR5, "1.570796370506", "2e-003");
  EXPECT_DOUBLE_EQ(ReadMicroLensGrid(Write("b.xml", all)).rotation, 0.002);
}

TEST_F(CameraFileTest, RaytrixRoundTripKeepsTheLattice) {
  const MicroLensGrid grid = *DistortedCamera().micro_lens_grid;
  WriteRaytrixGrid(Path("MLA_Calibration.xml"), grid);
  ExpectSameLattice(grid, ReadMicroLensGrid(Path("MLA_Calibration.xml")));
}

TEST_F(CameraFileTest, RealImagesAreKeplerianInXml) {
  WriteLifcalCamera(Path("a.xml"), ReadPlenopticCamera(Calibration("raytrix_r5_16mm.yaml")));
  EXPECT_EQ(ReadPlenopticCamera(Path("a.xml")).mode, MicroLensMode::kGalilean);
  const std::string lifcal = ReadTextFile(Path("a.xml"));
  const std::string real = Replace(lifcal, "</Root>", "<isReal>1</isReal></Root>");
  EXPECT_EQ(
      ReadPlenopticCamera(Write("b.xml", Replace(real, "IsKepler>false</IsKepler", "a></a"))).mode,
      MicroLensMode::kKeplerian);

  PlenopticCamera camera;
  AddMicroLensGrid(Write("c.xml", kRaytrixR5), &camera);
  EXPECT_EQ(camera.mode, MicroLensMode::kGalilean);
  EXPECT_EQ(camera.micro_lens_grid->types.size(), 3u);
  const std::string grid = Replace(kRaytrixR5, "</offset>", "</offset><isReal>true</isReal>");
  AddMicroLensGrid(Write("d.xml", grid), &camera);
  EXPECT_EQ(camera.mode, MicroLensMode::kKeplerian);
}

TEST_F(CameraFileTest, MetricCamerasHaveTheirImageOnTheModesSide) {
  const std::string good = ReadTextFile(Calibration("raytrix_r5_16mm.yaml"));
  EXPECT_NO_THROW(ReadMetricCamera(Write("good.yaml", good)));
  const std::string path = Write(
      "keplerian.yaml", Replace(good, "model: plenoptic", "model: plenoptic\nmode: keplerian"));
  EXPECT_NO_THROW(ReadPlenopticCamera(path));
  EXPECT_THAT(ErrorOf([&] { ReadMetricCamera(path); }), HasSubstr("Keplerian"));
}

TEST_F(CameraFileTest, PinholeTextWithComments) {
  const PinholeCamera camera = ReadPinholeCamera(Write(
      "calibration.txt", "# fx fy cx cy width height\n525 526 319.5 239.5 # Kinect\n640 480\n"));
  EXPECT_EQ(camera.fy, 526);
  EXPECT_EQ(camera.cx, 319.5);
  EXPECT_EQ(camera.height, 480);
}

TEST_F(CameraFileTest, BadFilesNameFileFoundAndExpected) {
  const std::string good = ReadTextFile(Calibration("raytrix_r5_16mm.yaml"));
  const std::string lifcal = [&] {
    WriteLifcalCamera(Path("good.xml"), DistortedCamera());
    return ReadTextFile(Path("good.xml"));
  }();
  struct Case {
    std::string name;
    std::string text;
    std::string found;
    std::string expected;
  };
  const Case cases[] = {
      {"missing.yaml",
       Replace(good, "focal_length_mm: 16.748", ""),
       "no key 'focal_length_mm'",
       "f_L in mm"},
      {"unknown.yaml", good + "focal_lenght_mm: 3\n", "'focal_lenght_mm'", "focal_length_mm"},
      {"zero.yaml", Replace(good, "16.748", "0"), "focal length (mm) of 0", "> 0"},
      {"negative.yaml", Replace(good, "16.748", "-16.7"), "focal length (mm) of -16.7", "> 0"},
      {"nan.yaml", Replace(good, "16.748", ".nan"), "'focal_length_mm' of '.nan'", "f_L in mm"},
      {"word.yaml", Replace(good, "0.376", "small"), "'small'", "B in mm"},
      {"mode.yaml", good + "mode: lytro\n", "the mode 'lytro'", "'galilean' or 'keplerian'"},
      {"model.yaml", Replace(good, "plenoptic", "fisheye"), "the model 'fisheye'", "'pinhole'"},
      {"pair.yaml", Replace(good, "[1018.7, 1054.2]", "[1018.7]"), "no list of 2", "raw px"},
      {"size.yaml", Replace(good, "[2048, 2048]", "[2048.5, 2048]"), "2048.5", "whole"},
      {"size2.yaml", Replace(good, "[2048, 2048]", "[1e30, 2048]"), "1e+30", "whole"},
      {"broken.yaml", "model: [plenoptic\n", "line", "YAML"},
      {"scalar.yaml", "plenoptic\n", "no map", "keys"},
      {"empty.yaml", "", "no map", "keys"},
      {"grid.yaml", Replace(good, "diameter_px: 23.2", "diameter_px: -1"), "-1", "4 or more"},
      {"missing.xml",
       Replace(lifcal, "<FocalLength units=\"mm\">35.368</FocalLength>", ""),
       "no element 'Root/FocalLength'",
       "'Root/FocalLength'"},
      {"value.xml", Replace(lifcal, "\"mm\">35.368", "\"mm\">35,368"), "'35,368'", "FocalLength"},
      {"nan.xml", Replace(lifcal, "\"mm\">35.368", "\"mm\">nan"), "'nan'", "a number"},
      {"root.xml", kRaytrixR5, "the root element 'RayCalibData'", "'Root'"},
      {"model.xml", Replace(lifcal, ">Plenoptic<", ">Pinhole<"), "'Pinhole'", "'Plenoptic'"},
      {"cut.xml", lifcal.substr(0, 200), "at byte", "well-formed XML"},
      {"short.txt", "525 525 320 240\n", "4 numbers", "fx fy cx cy width height"},
      {"word.txt", "525 525 320 240 640 high\n", "'high'", "fx fy cx cy width height"},
      {"zero.txt", "0 525 320 240 640 480\n", "fx (px) of 0", "> 0"},
      {"camera.json", "{}", "'.json'", ".yaml"},
  };
  for (const Case& c : cases) {
    const std::string path = Write(c.name, c.text);
    const std::string message = ErrorOf([&] { ReadCamera(path); });
    EXPECT_THAT(message,
                AllOf(HasSubstr(path + ": found "), HasSubstr(c.found), HasSubstr(c.expected)))
        << c.name;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  EXPECT_THAT(ErrorOf([&] { ReadCamera(Path("absent.yaml")); }), HasSubstr("no readable file"));
}

TEST_F(CameraFileTest, BadGridFilesNameFileFoundAndExpected) {
  const auto error = [&](const std::string& text) {
    const std::string path = Write("grid.xml", text);
    return ErrorOf([&] { ReadMicroLensGrid(path); });
  };
  EXPECT_THAT(error("<Root/>"),
              HasSubstr("found the root element 'Root', expected 'RayCalibData'"));
  EXPECT_THAT(error(Replace(kRaytrixR5, "23.2023", "")), HasSubstr("RayCalibData/diameter"));
  EXPECT_THAT(error(Replace(kRaytrixR5, "23.2023", "0.5")), HasSubstr("diameter of 0.5"));
  EXPECT_THAT(error(Replace(kRaytrixR5, "lens_type id=\"2\"", "x id=\"2\"")), HasSubstr("XML"));
  EXPECT_THAT(ErrorOf([&] { ReadMicroLensGrid(Path("absent.xml")); }),
              HasSubstr("no readable file"));
}

TEST_F(CameraFileTest, TheWrongModelIsAnError) {
  const std::string pinhole = Write("calibration.txt", "525 525 320 240 640 480");
  EXPECT_THAT(ErrorOf([&] { ReadPlenopticCamera(pinhole); }), HasSubstr("a pinhole camera"));
  EXPECT_THAT(ErrorOf([&] { ReadPinholeCamera(Calibration("raytrix_r5_16mm.yaml")); }),
              HasSubstr("a plenoptic camera"));
}

TEST_F(CameraFileTest, NothingIsWrittenIntoAFolderThatDoesNotExist) {
  const PinholeCamera pinhole{640, 480, 525, 525, 320, 240};
  EXPECT_THROW(WriteNativeCamera(Path("none/camera.yaml"), pinhole), InputError);
  EXPECT_FALSE(std::filesystem::exists(Path("none")));
}

}  // namespace
}  // namespace prism
