// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/map_file.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"

namespace prism {
namespace {

using testing::HasSubstr;

PlenopticProjection Camera() {
  PlenopticProjection camera;
  camera.f = 0.0167;
  camera.s = 11e-6;
  camera.c = {32, 24};
  camera.width = 64;
  camera.height = 48;
  return camera;
}

std::vector<MappedPlace> SomePlaces() {
  std::vector<MappedPlace> places(2);
  for (int i = 0; i < 2; ++i) {
    Place& place = places[i].place;
    place.keyframe_id = 3 + i;
    cv::Mat image(48, 64, CV_8U);
    cv::randu(image, 0, 255);
    cv::imencode(".jpg", image, place.image);
    place.points = {{1.5F, 2.25F, 0.3F, 0.01F}, {10, 20, 1 / 3.0F, 0}};
    place.median_rho = 0.3F;
    place.features = {{5, 6, 0.7F}, {7, 8, 0}};
    place.descriptors = cv::Mat(2, 32, CV_8U);
    cv::randu(place.descriptors, 0, 255);
    places[i].time_ns = 1234567890123456789 + i;
    places[i].cam_from_world = SE3::Exp((Vector6d() << 1, 2, 3, 0.1, 0.2, 0.3 + i).finished());
  }
  // A view without anything that can be found.
  places[1].place.features.clear();
  places[1].place.descriptors = cv::Mat();
  return places;
}

std::string Folder(const std::string& name) {
  const std::string folder = testing::TempDir() + "map_file_test/" + name;
  std::filesystem::remove_all(folder);
  return folder;
}

void ExpectRefused(const std::string& folder, const PlenopticProjection& camera, const char* text) {
  try {
    ReadMap(folder, camera);
    FAIL() << "expected an error with '" << text << "'";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr(text));
  }
}

void Replace(const std::string& path, const std::string& from, const std::string& to) {
  std::string text = ReadTextFile(path);
  const size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  WriteTextAtomically(path, text.replace(at, from.size(), to));
}

TEST(MapFile, GivesBackWhatWasWritten) {
  const std::string folder = Folder("round_trip");
  const std::vector<MappedPlace> written = SomePlaces();
  WriteMap(folder, Camera(), written);
  const std::vector<MappedPlace> read = ReadMap(folder, Camera());
  ASSERT_EQ(read.size(), written.size());
  for (size_t i = 0; i < read.size(); ++i) {
    const Place &a = written[i].place, &b = read[i].place;
    EXPECT_EQ(a.keyframe_id, b.keyframe_id);
    EXPECT_EQ(a.image, b.image);
    ASSERT_EQ(a.points.size(), b.points.size());
    EXPECT_EQ(a.points[1].rho, b.points[1].rho);
    EXPECT_EQ(a.points[0].y, b.points[0].y);
    ASSERT_EQ(a.features.size(), b.features.size());
    EXPECT_EQ(a.descriptors.rows, b.descriptors.rows);
    EXPECT_EQ(a.descriptors.rows == 0 ? 0 : cv::norm(a.descriptors, b.descriptors), 0);
    EXPECT_EQ(written[i].time_ns, read[i].time_ns);
    EXPECT_LT((written[i].cam_from_world * read[i].cam_from_world.Inverse()).Log().norm(), 1e-12);
  }
}

TEST(MapFile, WhatIsNoMapOfThisCameraIsRefused) {
  ExpectRefused(Folder("missing"), Camera(), "no such file");
  const std::string folder = Folder("bad");
  WriteMap(folder, Camera(), SomePlaces());
  PlenopticProjection other = Camera();
  other.f *= 1.02;
  ExpectRefused(folder, other, "places of a camera of 64 x 48 px");
  other = Camera();
  other.width = 32;
  ExpectRefused(folder, other, "64 x 48");

  const std::string file = folder + "/map.yml";
  const std::string good = ReadTextFile(file);
  const auto with = [&](const std::string& from, const std::string& to, const char* text) {
    WriteTextAtomically(file, good);
    Replace(file, from, to);
    ExpectRefused(folder, Camera(), text);
  };
  with("version: 1", "version: 2", "images of chief rays");
  with("version: 1", "version: 3", "version 3");
  with("prism_map", "other_map", "another format");
  with("%YAML", "%NOTHING", "another format");
  with("id: 4", "id: 3", "two places of id 3");
  with("cam_from_world", "cam_from_here", "cam_from_world");
  with("cols: 4", "cols: 5", "points");
  WriteTextAtomically(file, good.substr(0, good.size() / 2));
  EXPECT_THROW(ReadMap(folder, Camera()), InputError);
  WriteTextAtomically(file, good);
  std::filesystem::remove(folder + "/images/000003.jpg");
  ExpectRefused(folder, Camera(), "000003.jpg");
}

}  // namespace
}  // namespace prism
