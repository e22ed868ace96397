// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/export/mcap.h"

#include <algorithm>
#include <cstring>
#include <set>

#include <google/protobuf/descriptor.pb.h>

#include "prism/base/error.h"
#include "prism/base/format.h"
#include "prism/export/foxglove/foxglove.pb.h"
#include "prism/export/mcap_writer.h"
#include "prism/io/atomic_file.h"

namespace prism {
namespace {

constexpr char kWorld[] = "world";
constexpr char kCamera[] = "camera";
// Where the pinhole of the images stands.
const char* PinholeFrame(const PlenopticProjection& camera) {
  return camera.image == FocusedImage::kChiefRays ? "main_lens" : "front_focal_point";
}

void AddFile(const google::protobuf::FileDescriptor& file,
             std::set<std::string>* known,
             google::protobuf::FileDescriptorSet* files) {
  if (!known->insert(file.name()).second) return;
  for (int i = 0; i < file.dependency_count(); ++i) AddFile(*file.dependency(i), known, files);
  file.CopyTo(files->add_file());
}

// A topic of messages of one type.
template <typename Message>
uint16_t AddTopic(const std::string& topic, McapWriter* writer) {
  google::protobuf::FileDescriptorSet files;
  std::set<std::string> known;
  AddFile(*Message::descriptor()->file(), &known, &files);
  const uint16_t schema =
      writer->AddSchema(Message::descriptor()->full_name(), files.SerializeAsString());
  return writer->AddChannel(schema, topic);
}

template <typename Message>
void SetTime(int64_t time_ns, Message* message) {
  message->mutable_timestamp()->set_seconds(time_ns / 1000000000);
  message->mutable_timestamp()->set_nanos(static_cast<int>(time_ns % 1000000000));
}

std::string Transform(int64_t time_ns, const char* parent, const char* child, const SE3& pose) {
  foxglove::FrameTransform transform;
  SetTime(time_ns, &transform);
  transform.set_parent_frame_id(parent);
  transform.set_child_frame_id(child);
  const Eigen::Vector3d t = pose.translation();
  transform.mutable_translation()->set_x(t.x());
  transform.mutable_translation()->set_y(t.y());
  transform.mutable_translation()->set_z(t.z());
  const Eigen::Quaterniond q = pose.rotation();
  transform.mutable_rotation()->set_x(q.x());
  transform.mutable_rotation()->set_y(q.y());
  transform.mutable_rotation()->set_z(q.z());
  transform.mutable_rotation()->set_w(q.w());
  return transform.SerializeAsString();
}

std::string Calibration(int64_t time_ns, const PlenopticProjection& camera) {
  foxglove::CameraCalibration calibration;
  SetTime(time_ns, &calibration);
  calibration.set_frame_id(PinholeFrame(camera));
  calibration.set_width(camera.width);
  calibration.set_height(camera.height);
  const double f = camera.FocalLengthPx();
  for (const double k : {f, 0.0, camera.c.x(), 0.0, f, camera.c.y(), 0.0, 0.0, 1.0}) {
    calibration.add_k(k);
  }
  for (const double r : {1, 0, 0, 0, 1, 0, 0, 0, 1}) calibration.add_r(r);
  for (const double p :
       {f, 0.0, camera.c.x(), 0.0, 0.0, f, camera.c.y(), 0.0, 0.0, 0.0, 1.0, 0.0}) {
    calibration.add_p(p);
  }
  return calibration.SerializeAsString();
}

std::string Picture(const ExportKeyframe& keyframe, const std::string& frame) {
  foxglove::CompressedImage image;
  SetTime(keyframe.time_ns, &image);
  image.set_frame_id(frame);
  image.set_format("png");
  image.set_data(keyframe.image.data(), keyframe.image.size());
  return image.SerializeAsString();
}

std::string Cloud(int64_t time_ns, const std::vector<ExportPoint>& points) {
  foxglove::PointCloud cloud;
  SetTime(time_ns, &cloud);
  cloud.set_frame_id(kWorld);
  cloud.mutable_pose()->mutable_position();
  cloud.mutable_pose()->mutable_orientation()->set_w(1);
  constexpr uint32_t kStride = 20;
  cloud.set_point_stride(kStride);
  using Field = foxglove::PackedElementField;
  const auto add_field = [&](const char* name, uint32_t offset, Field::NumericType type) {
    Field* field = cloud.add_fields();
    field->set_name(name);
    field->set_offset(offset);
    field->set_type(type);
  };
  add_field("x", 0, Field::FLOAT32);
  add_field("y", 4, Field::FLOAT32);
  add_field("z", 8, Field::FLOAT32);
  add_field("sigma", 12, Field::FLOAT32);
  add_field("red", 16, Field::UINT8);
  add_field("green", 17, Field::UINT8);
  add_field("blue", 18, Field::UINT8);
  add_field("alpha", 19, Field::UINT8);
  std::string& data = *cloud.mutable_data();
  data.reserve(kStride * points.size());
  for (const ExportPoint& point : points) {
    char bytes[kStride];
    const Eigen::Vector3f p = point.p_in_world.cast<float>();
    const auto sigma = static_cast<float>(point.sigma_m);
    std::memcpy(bytes, p.data(), 12);
    std::memcpy(bytes + 12, &sigma, 4);
    std::memcpy(bytes + 16, point.rgb.data(), 3);
    bytes[19] = '\xff';
    data.append(bytes, kStride);
  }
  return cloud.SerializeAsString();
}

}  // namespace

std::string WriteMcap(const std::string& folder, const ExportRun& run) {
  const std::string path = InFolder(folder, "run.mcap");
  McapWriter writer;
  const uint16_t tf = AddTopic<foxglove::FrameTransform>("/tf", &writer);
  const uint16_t images = AddTopic<foxglove::CompressedImage>("/image", &writer);
  const uint16_t calibrations = AddTopic<foxglove::CameraCalibration>("/calibration", &writer);
  const uint16_t points = AddTopic<foxglove::PointCloud>("/points", &writer);
  if (!run.trajectory.empty()) {
    const int64_t start_ns = run.trajectory.front().time_ns;
    if (start_ns < 0) throw InputError(path, "times before 1970", "times that MCAP can hold");
    writer.AddMessage(points, start_ns, Cloud(start_ns, run.points));
  }
  const char* pinhole = PinholeFrame(run.camera);
  const SE3 camera_from_pinhole = WorldFromPinhole(run.camera, SE3());
  for (const StampedPose& pose : run.trajectory) {
    writer.AddMessage(
        tf, pose.time_ns, Transform(pose.time_ns, kWorld, kCamera, pose.world_from_cam));
    writer.AddMessage(
        tf, pose.time_ns, Transform(pose.time_ns, kCamera, pinhole, camera_from_pinhole));
    for (const ExportKeyframe& keyframe : run.keyframes) {
      if (keyframe.time_ns != pose.time_ns) continue;
      writer.AddMessage(calibrations, pose.time_ns, Calibration(pose.time_ns, run.camera));
      writer.AddMessage(images, pose.time_ns, Picture(keyframe, pinhole));
    }
  }
  WriteTextAtomically(path, writer.Finish());
  return Format("%zu poses, %zu images, %zu points",
                run.trajectory.size(),
                run.keyframes.size(),
                run.points.size());
}

}  // namespace prism
