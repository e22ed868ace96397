// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/micro_image_corners.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"
#include "test/io/rgbd_folder.h"

namespace prism {
namespace {

using ::testing::HasSubstr;

class MicroImageCornersTest : public ::testing::Test {
 protected:
  MicroImageCornersTest() : folder_(FreshFolder("csv")) {}
  ~MicroImageCornersTest() override { std::filesystem::remove_all(folder_); }

  std::vector<MicroImageCorner> Read(const std::string& corners, const std::string& centers) {
    WriteTextAtomically(folder_ + "/corners.csv", corners);
    WriteTextAtomically(folder_ + "/centers.csv", centers);
    return ReadMicroImageCorners(folder_ + "/corners.csv", folder_ + "/centers.csv");
  }
  std::string Error(const std::string& corners, const std::string& centers) {
    try {
      Read(corners, centers);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  std::string folder_;
};

constexpr char kCenters[] = "k,l,u,v\n0,0,10,10\n0,1,10,33\n1,0,33,10\n";

TEST_F(MicroImageCornersTest, ColumnsMayStandInAnyOrder) {
  const auto corners = Read("frame,cluster,u,v,rho,k,l\r\n2,7,12.5,11,9,0,0\r\n2,7,34,12,9,1,0\r\n",
                            "\xEF\xBB\xBFx,y,k,l\n10,10,0,0\n33,10,1,0\n");
  ASSERT_EQ(corners.size(), 2u);
  EXPECT_EQ(corners[0].frame, 2);
  EXPECT_EQ(corners[0].cluster, 7);
  EXPECT_EQ(corners[0].px, Eigen::Vector2d(12.5, 11));
  EXPECT_EQ(corners[1].micro_image_px, Eigen::Vector2d(33, 10));
}

TEST_F(MicroImageCornersTest, BadFilesAreNamedWithTheLine) {
  EXPECT_THAT(Error("k,l,u,v,cluster\n0,0,1,1,1\n", kCenters), HasSubstr("no column 'frame'"));
  EXPECT_THAT(Error("k,l,u,v,cluster,frame\n0,0,x,10,1,1\n", kCenters), HasSubstr("'x' in line 2"));
  EXPECT_THAT(Error("k,l,u,v,cluster,frame\n5,0,10,10,1,1\n", kCenters),
              HasSubstr("without centre in line 2"));
  EXPECT_THAT(Error("k,l,u,v,cluster,frame\n0,0,80,10,1,1\n", kCenters),
              HasSubstr("outside its micro image"));
  EXPECT_THAT(Error("k,l,u,v,cluster,frame\n", kCenters), HasSubstr("no lines"));
  EXPECT_THAT(Error("k,l,u,v,cluster,frame\n0,0,10,10,1,1\n", "k,l,u,v\n0,0,1,1\n0,0,2,2\n"),
              HasSubstr("twice"));
  EXPECT_THAT(Error("k,l,u,v,cluster,frame\n0,0,10,10,1,1e300\n", kCenters),
              HasSubstr("'1e+300' in line 2"));
  EXPECT_THAT(Error("k,l,u,v,cluster,frame\n0,0.4,10,10,1,1\n", kCenters),
              HasSubstr("'0.4' in line 2"));
  EXPECT_THAT(Error("k,l,u,v,cluster,frame\n0,0,1e5,10,1,1\n", "k,l,u,v\n0,0,1,1\n"),
              HasSubstr("one micro image"));
}

}  // namespace
}  // namespace prism
