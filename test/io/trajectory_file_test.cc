// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/trajectory_file.h"

#include <cmath>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"

namespace prism {
namespace {

using ::testing::HasSubstr;

class TrajectoryFileTest : public ::testing::Test {
 protected:
  TrajectoryFileTest() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    directory_ =
        std::filesystem::path(::testing::TempDir()) / ("trajectory_" + std::string(info->name()));
    CreateDirectory(directory_.string());
  }
  ~TrajectoryFileTest() override { std::filesystem::remove_all(directory_); }

  std::string File(const std::string& name, const std::string& contents) const {
    const std::string path = (directory_ / name).string();
    WriteTextAtomically(path, contents);
    return path;
  }

  // The message of the InputError that reading `contents` throws; empty if it throws none.
  std::string ErrorOf(const std::string& contents,
                      const TrajectoryReadOptions& options = {}) const {
    try {
      ReadTrajectory(File("bad.txt", contents), options);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path directory_;
};

TEST_F(TrajectoryFileTest, WhatIsWrittenIsReadBackWithExactTimesAndNineDigits) {
  Trajectory written;
  for (int i = 0; i < 20; ++i) {
    Vector6d tangent;
    tangent << 1234.56789 * i, -0.001 * i, 3, 0.1 * i, 0.05, -0.02 * i;
    written.push_back({1403636580838555574 + 33333333 * int64_t{i}, SE3::Exp(tangent)});
  }
  const std::string path = (directory_ / "trajectory.txt").string();
  WriteTrajectory(path, written);
  const Trajectory read = ReadTrajectory(path);
  ASSERT_EQ(read.size(), written.size());
  for (size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].time_ns, written[i].time_ns);
    const Eigen::Vector3d t = written[i].world_from_cam.translation();
    EXPECT_LE((read[i].world_from_cam.translation() - t).norm(), 5.01e-9 * t.norm());
    EXPECT_LE(RotationAngle(read[i].world_from_cam.Inverse() * written[i].world_from_cam), 1e-8);
  }
}

TEST_F(TrajectoryFileTest, NegativeTimesKeepTheirSign) {
  EXPECT_THAT(FormatTrajectory({{-500000000, SE3()}}), HasSubstr("-0.500000000 0 0 0 0 0 0 1"));
}

TEST_F(TrajectoryFileTest, TumLinesMayHaveCommentsTabsAndExponents) {
  const Trajectory read = ReadTrajectory(File(
      "tum.txt", "# time tx ty tz qx qy qz qw\n\n1.5\t1 2 3e0 0 0 0 1\r\n1.75e0 1 2 4 1 0 0 0"));
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].time_ns, 1500000000);
  EXPECT_EQ(read[1].time_ns, 1750000000);
  EXPECT_EQ(read[1].world_from_cam.translation(), Eigen::Vector3d(1, 2, 4));
  EXPECT_NEAR(RotationAngle(read[1].world_from_cam), M_PI, 1e-12);
}

TEST_F(TrajectoryFileTest, EurocHasNanosecondsAndTheScalarFirst) {
  const Trajectory read =
      ReadTrajectory(File("data.csv",
                          "#timestamp,p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],...\n"
                          "1403636580838555648,4.6,-1.7,0.8,0.8,0.6,0,0,-0.05,0.03,0.8\n"));
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].time_ns, 1403636580838555648);
  EXPECT_EQ(read[0].world_from_cam.translation(), Eigen::Vector3d(4.6, -1.7, 0.8));
  EXPECT_NEAR(read[0].world_from_cam.rotation().w(), 0.8, 1e-12);
  EXPECT_NEAR(read[0].world_from_cam.rotation().x(), 0.6, 1e-12);
}

TEST_F(TrajectoryFileTest, KittiTakesTimesFromARateOrAFile) {
  const std::string poses = File("00.txt", "1 0 0 5 0 1 0 6 0 0 1 7\n0 -1 0 8 1 0 0 9 0 0 1 10\n");
  TrajectoryReadOptions with_rate;
  with_rate.kitti_rate_hz = 10;
  const Trajectory read = ReadTrajectory(poses, with_rate);
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[1].time_ns, 100000000);
  EXPECT_EQ(read[1].world_from_cam.translation(), Eigen::Vector3d(8, 9, 10));
  const Eigen::Vector3d turned_x = read[1].world_from_cam.rotation() * Eigen::Vector3d::UnitX();
  EXPECT_LE((turned_x - Eigen::Vector3d::UnitY()).norm(), 1e-12);

  TrajectoryReadOptions with_times;
  with_times.kitti_times_path = File("times.txt", "0.000000e+00\n1.037059e-01\n");
  EXPECT_EQ(ReadTrajectory(poses, with_times)[1].time_ns, 103705900);
  with_times.kitti_times_path = File("times.txt", "0\n0.1\n0.2\n");
  EXPECT_THROW(ReadTrajectory(poses, with_times), InputError);
}

TEST_F(TrajectoryFileTest, AQuaternionNearUnitIsNormalised) {
  const Trajectory read = ReadTrajectory(File("near.txt", "0 1 2 3 0 0 0.6 0.81\n"));
  ASSERT_EQ(read.size(), 1u);
  EXPECT_NEAR(read[0].world_from_cam.rotation().norm(), 1, 1e-12);
}

TEST_F(TrajectoryFileTest, BadFilesAreRefusedWithFileLineAndReason) {
  const std::string good = "0 0 0 0 0 0 0 1\n";
  EXPECT_THAT(ErrorOf(""), HasSubstr("bad.txt: found no pose"));
  EXPECT_THAT(ErrorOf(" \n\t\n \r\n"), HasSubstr("bad.txt: found no pose"));
  EXPECT_THAT(ErrorOf("# only a comment\n"), HasSubstr("found no pose"));
  EXPECT_THAT(ErrorOf(good + "1 nan 0 0 0 0 0 1\n"), HasSubstr("bad.txt, line 2: found 'nan'"));
  EXPECT_THAT(ErrorOf(good + "inf 0 0 0 0 0 0 1\n"), HasSubstr("line 2: found 'inf'"));
  EXPECT_THAT(ErrorOf(good + "1 0 0 0 0 0 0\n"), HasSubstr("line 2: found too few columns"));
  EXPECT_THAT(ErrorOf(good + "1 0 0 0 0 0 0 1 5\n"), HasSubstr("line 2: found more columns"));
  EXPECT_THAT(ErrorOf(good + "1 0 zero 0 0 0 0 1\n"), HasSubstr("line 2: found 'zero'"));
  EXPECT_THAT(ErrorOf(good + good), HasSubstr("line 2: found the time of the pose before"));
  EXPECT_THAT(ErrorOf("1 0 0 0 0 0 0 1\n" + good),
              HasSubstr("found a time before the previous one"));
  EXPECT_THAT(ErrorOf("0 0 0 0 0 0 0 0.9\n"), HasSubstr("a quaternion of norm 0.9"));
  EXPECT_THAT(ErrorOf("0 0 0 0 0 0 0 0\n"), HasSubstr("a quaternion of norm 0"));
  EXPECT_THAT(ErrorOf("1403636580838555648 0 0 0 0 0 0 1\n"), HasSubstr("more than 292 years"));
  EXPECT_THAT(ErrorOf("1 0 0 0 0 1 0 0 0 0 1 0\n"), HasSubstr("KITTI poses without times"));
  TrajectoryReadOptions kitti;
  kitti.kitti_rate_hz = 10;
  EXPECT_THAT(ErrorOf("2 0 0 0 0 1 0 0 0 0 1 0\n", kitti), HasSubstr("no rotation matrix"));
  EXPECT_THAT(ErrorOf("-1 0 0 0 0 1 0 0 0 0 1 0\n", kitti), HasSubstr("no rotation matrix"));
  EXPECT_THAT(ErrorOf("1.5,0,0,0,1,0,0,0\n"), HasSubstr("line 1: found '1.5'"));
  EXPECT_THROW(ReadTrajectory((directory_ / "missing.txt").string()), InputError);
  EXPECT_THROW(ReadTrajectory(directory_.string()), InputError);
}

}  // namespace
}  // namespace prism
