// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/export/export.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/export/dense_points.h"
#include "prism/export/euroc.h"
#include "prism/export/kitti.h"
#include "prism/export/tracks.h"
#include "prism/export/triangulation.h"
#include "prism/io/trajectory_file.h"
#include "test/export/sample_run.h"

namespace prism {
namespace {

double MeanError(const std::vector<Track>& tracks, int* observations) {
  double sum = 0;
  *observations = 0;
  for (const Track& track : tracks) {
    const int others = static_cast<int>(track.observations.size()) - 1;
    sum += others * track.mean_error;
    *observations += others;
  }
  return sum / *observations;
}

TEST(Frame, DepthAndSigmaSurviveEncoding) {
  const PlenopticProjection camera = SampleCamera();
  LightFieldFrame frame = ViewOfWall(camera, SE3(), 1);
  frame.sigma(5, 7) = frame.inverse_virtual_depth(5, 7) = 0;
  ExportKeyframe keyframe;
  EncodeFrame(frame, &keyframe);
  const DepthMap map = DecodeDepth(keyframe);
  EXPECT_EQ(map.inverse_virtual_depth(5, 7), 0);
  EXPECT_EQ(map.sigma(5, 7), 0);
  EXPECT_NEAR(map.inverse_virtual_depth(9, 7), frame.inverse_virtual_depth(9, 7), 1e-5);
  EXPECT_NEAR(map.sigma(9, 7), 0.002, 1e-6);
  EXPECT_NEAR(DecodeGray(keyframe).at<uint8_t>(7, 9), frame.image[0](9, 7), 0.5);
}

TEST(Tracks, PointsAreFoundWhereTheyAreWhateverTheExposure) {
  const ExportRun run = SampleRun();
  const std::vector<Track> tracks = FindTracks(run);
  int observations;
  const double error = MeanError(tracks, &observations);
  EXPECT_LT(error, 0.08);
  EXPECT_GT(observations, 3 * static_cast<int>(run.points.size()));
}

TEST(Tracks, ObservationsAreMeasuredAndTellAWrongPose) {
  ExportRun run = SampleRun();
  // One keyframe where it is not: 4 mm at 1.5 m are 1.08 px.
  SE3& pose = run.keyframes[3].world_from_cam;
  pose = pose * SE3(Eigen::Quaterniond::Identity(), {0.004, 0, 0});
  const SE3 cam_from_world = pose.Inverse();
  const std::vector<Track> tracks = FindTracks(run);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (size_t i = 0; i < tracks.size(); ++i) {
    if (run.points[i].keyframe_id == run.keyframes[3].id) continue;
    for (const Observation& seen : tracks[i].observations) {
      if (seen.keyframe != 3) continue;
      Eigen::Vector2d projection;
      ASSERT_TRUE(
          ProjectToKeyframe(run.camera, cam_from_world, run.points[i].p_in_world, &projection));
      sum += seen.px - projection;
      ++count;
    }
  }
  ASSERT_GT(count, 100);
  EXPECT_NEAR(sum.x() / count, 1.08, 0.05);
  EXPECT_NEAR(sum.y() / count, 0, 0.05);
}

TEST(Triangulation, MovesAPointToWhereItsObservationsMeet) {
  const ExportRun run = SampleRun();
  const std::vector<Track> tracks = FindTracks(run);
  std::vector<SE3> poses;
  for (const ExportKeyframe& keyframe : run.keyframes) {
    poses.push_back(keyframe.world_from_cam.Inverse());
  }
  double error_px = 0, error_m = 0;
  int count = 0;
  for (size_t i = 0; i < tracks.size(); ++i) {
    if (tracks[i].observations.size() < 5) continue;
    const Eigen::Vector3d& truth = run.points[i].p_in_world;
    const Eigen::Vector3d wrong = truth + Eigen::Vector3d(0.01, -0.02, 0.1);
    const TriangulatedPoint point = Triangulate(run.camera, poses, tracks[i], wrong);
    error_px += point.mean_error;
    error_m += (point.p_in_world - truth).norm();
    ++count;
  }
  ASSERT_GT(count, 200);
  EXPECT_LT(error_px / count, 0.06);
  EXPECT_LT(error_m / count, 0.006);
}

TEST(DensePoints, AreThoseThatKeyframesAgreeOn) {
  ExportRun run = SampleRun();
  // What stands before the wall in one depth map alone.
  LightFieldFrame frame = ViewOfWall(run.camera, run.keyframes[2].world_from_cam, 1);
  const double near = InverseVirtualDepth(run.camera, 1 / 0.7);
  for (int y = 100; y < 140; ++y) {
    for (int x = 100; x < 160; ++x) {
      frame.inverse_virtual_depth(x, y) = static_cast<float>(near);
    }
  }
  EncodeFrame(frame, &run.keyframes[2]);
  const std::vector<OrientedPoint> points = FuseDepth(run);
  // The wall once, not once a keyframe.
  EXPECT_GT(points.size(), 0.8 * 320 * 240);
  EXPECT_LT(points.size(), 1.6 * 320 * 240);
  for (const OrientedPoint& point : points) {
    ASSERT_NEAR(point.position.z(), kWallDepth, 0.01);
    ASSERT_NEAR(point.view_direction.norm(), 1, 1e-5);
    ASSERT_LT(point.view_direction.z(), -0.5);  // towards the cameras
    ASSERT_GT(point.sigma_m, 0);
  }
}

TEST(Trajectories, ComeBackFromKittiAndEuroc) {
  const ExportRun run = SampleRun();
  const std::string folder = testing::TempDir() + "export_trajectories";
  std::filesystem::create_directories(folder);
  EXPECT_EQ(WriteKitti(folder, run), "12 poses");
  EXPECT_EQ(WriteEuroc(folder, run), "12 poses");
  TrajectoryReadOptions kitti;
  kitti.kitti_times_path = folder + "/trajectory_kitti_times.txt";
  for (const Trajectory& read : {ReadTrajectory(folder + "/trajectory_kitti.txt", kitti),
                                 ReadTrajectory(folder + "/trajectory_euroc.csv")}) {
    ASSERT_EQ(read.size(), run.trajectory.size());
    for (size_t i = 0; i < read.size(); ++i) {
      EXPECT_EQ(read[i].time_ns, run.trajectory[i].time_ns);
      const SE3 error = read[i].world_from_cam.Inverse() * run.trajectory[i].world_from_cam;
      EXPECT_LT(error.Log().norm(), 1e-7);
    }
  }
  std::filesystem::remove_all(folder);
}

TEST(Names, AreTold) {
  EXPECT_EQ(ExportNames(), "colmap, nerfstudio, kitti, euroc, mcap, ply or dense");
  EXPECT_TRUE(IsExportName("mcap"));
  EXPECT_FALSE(IsExportName("rosbag"));
}

}  // namespace
}  // namespace prism
