// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// The Python module `prism`; prism.pyi says what each thing takes and returns.
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "prism/base/error.h"
#include "prism/base/version.h"
#include "prism/camera/projection.h"
#include "prism/io/camera_file.h"
#include "prism/io/trajectory_file.h"
#include "prism/lightfield/chief_rays.h"
#include "prism/lightfield/light_field_processor.h"
#include "prism/odometry/odometry.h"
#include "prism/python/evaluation.h"
#include "prism/python/frames.h"
#include "prism/run/sequence.h"

namespace prism {
namespace {

namespace py = pybind11;
using Points3 = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Points2 = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

int64_t Nanoseconds(double seconds) { return std::llround(1e9 * seconds); }
double Seconds(int64_t time_ns) { return 1e-9 * static_cast<double>(time_ns); }

Eigen::Matrix4d MatrixOf(const SE3& pose) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = pose.RotationMatrix();
  matrix.topRightCorner<3, 1>() = pose.translation();
  return matrix;
}

PlenopticCamera ReadCameraAndGrid(const std::string& path, const std::string& micro_lens_grid) {
  PlenopticCamera camera = ReadPlenopticCamera(path);
  if (!micro_lens_grid.empty()) AddMicroLensGrid(micro_lens_grid, &camera);
  return camera;
}

Points3 ProjectAll(const PlenopticCamera& camera, const Points3& points) {
  const PlenopticProjection projection(camera);
  Points3 pixels = Points3::Constant(points.rows(), 3, NAN);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    Eigen::Vector3d x_V;
    if (Project(projection, points.row(i).transpose(), &x_V)) {
      pixels.row(i) << x_V.x(), x_V.y(), 1 / x_V.z();
    }
  }
  return pixels;
}

Points3 UnprojectAll(const PlenopticCamera& camera, const Points3& pixels) {
  const PlenopticProjection projection(camera);
  Points3 points = Points3::Constant(pixels.rows(), 3, NAN);
  for (Eigen::Index i = 0; i < pixels.rows(); ++i) {
    const double w = pixels(i, 2);
    if (!(w > 0 && w * projection.b_L0 + projection.B > 0)) continue;
    const double rho = InverseDepth(projection, w);
    if (rho <= 0) continue;
    points.row(i) =
        UnprojectInverseDepth(projection, pixels.row(i).head<2>().transpose(), rho).transpose();
  }
  return points;
}

// Light field of single frames, kept for the next: tables are made once.
class LightField {
 public:
  LightField(const PlenopticCamera& camera, const std::optional<py::array>& white, int threads) {
    if (!camera.micro_lens_grid) {
      throw py::value_error("camera: found no micro-lens grid, expected one for raw frames");
    }
    LightFieldOptions options;
    options.threads = threads;
    const cv::Mat image = white ? MakeRawFrame(camera, 0, *white).image.clone() : cv::Mat();
    processor_ = std::make_unique<LightFieldProcessor>(camera, image, options);
  }

  LightFieldFrame Process(const py::array& image, double time) {
    const RawFrame raw = MakeRawFrame(processor_->camera(), Nanoseconds(time), image);
    const py::gil_scoped_release release;
    return processor_->Process(raw);
  }

 private:
  std::unique_ptr<LightFieldProcessor> processor_;
};

// An odometry, and the light field of its raw frames once there is one.
class PythonOdometry {
 public:
  PythonOdometry(const PlenopticCamera& camera,
                 std::optional<py::array> white,
                 int threads,
                 int window_keyframes,
                 int active_points,
                 const std::string& focused_image)
      : frames_camera_(camera), camera_(camera), white_(std::move(white)), threads_(threads) {
    FocusedImage image;
    if (!ParseFocusedImage(focused_image, &image)) {
      throw py::value_error(std::string("focused_image: expected ") + kFocusedImages);
    }
    if (camera.focused_image == FocusedImage::kVirtualPoints) camera_.focused_image = image;
    OdometryOptions options;
    options.window.solve.threads = threads;
    options.window.max_keyframes = window_keyframes;
    options.window.max_points = active_points;
    std::string error;
    if (!options.IsValid(&error)) throw py::value_error(error);
    odometry_ = std::make_unique<Odometry>(camera_, options);
  }

  FrameResult Process(const FloatArray& image,
                      const FloatArray& inverse_virtual_depth,
                      const FloatArray& sigma,
                      double time) {
    return ProcessFrame(
        MakeFrame(frames_camera_, Nanoseconds(time), image, inverse_virtual_depth, sigma));
  }

  // As the camera given has them.
  FrameResult ProcessFrame(LightFieldFrame frame) {
    const py::gil_scoped_release release;
    if (frames_camera_.focused_image != camera_.focused_image) {
      frame = ToChiefRays(frames_camera_, frame);
    }
    return odometry_->Process(std::move(frame));
  }

  FrameResult ProcessRaw(const py::array& image, double time) {
    if (!light_field_) light_field_ = std::make_unique<LightField>(camera_, white_, threads_);
    LightFieldFrame frame = light_field_->Process(image, time);
    const py::gil_scoped_release release;
    return odometry_->Process(std::move(frame));
  }

  py::array_t<double> TrajectoryRows() const { return ArrayOf(odometry_->FrameTrajectory()); }
  py::array_t<double> KeyframeRows() const { return ArrayOf(odometry_->KeyframeTrajectory()); }
  void Write(const std::string& path) const { WriteTrajectory(path, odometry_->FrameTrajectory()); }

  // Positions (n x 3, m), colours (n x 3) and standard deviations along the rays (n, m).
  py::tuple Points() const {
    const std::vector<MapPoint> points = odometry_->MapPoints();
    const auto count = static_cast<py::ssize_t>(points.size());
    py::array_t<double> positions({count, py::ssize_t{3}});
    py::array_t<uint8_t> colours({count, py::ssize_t{3}});
    py::array_t<double> sigmas(count);
    auto p = positions.mutable_unchecked<2>();
    auto c = colours.mutable_unchecked<2>();
    auto s = sigmas.mutable_unchecked<1>();
    for (py::ssize_t i = 0; i < count; ++i) {
      for (int k = 0; k < 3; ++k) {
        p(i, k) = points[i].p_in_world(k);
        c(i, k) = points[i].rgb[k];
      }
      s(i) = points[i].sigma_m;
    }
    return py::make_tuple(positions, colours, sigmas);
  }

 private:
  PlenopticCamera frames_camera_;  // as given
  PlenopticCamera camera_;         // of what is tracked
  std::optional<py::array> white_;
  int threads_;
  std::unique_ptr<Odometry> odometry_;
  std::unique_ptr<LightField> light_field_;
};

// A view of an image of `owner`, without a copy; it keeps the owner alive.
py::array_t<float> ViewOf(const ImageF& image, const py::object& owner) {
  return py::array_t<float>({image.height(), image.width()}, image.data(), owner);
}

void BindCamera(py::module_* module) {
  py::class_<PlenopticCamera>(*module, "Camera")
      .def_static("read", &ReadCameraAndGrid, py::arg("path"), py::arg("micro_lens_grid") = "")
      .def_readonly("focal_length", &PlenopticCamera::focal_length)
      .def_readonly("main_lens_mla_distance", &PlenopticCamera::main_lens_mla_distance)
      .def_readonly("sensor_mla_distance", &PlenopticCamera::sensor_mla_distance)
      .def_readonly("raw_width", &PlenopticCamera::raw_width)
      .def_readonly("raw_height", &PlenopticCamera::raw_height)
      .def_property_readonly("width", &PlenopticCamera::focused_width)
      .def_property_readonly("height", &PlenopticCamera::focused_height)
      .def_property_readonly("has_micro_lens_grid",
                             [](const PlenopticCamera& c) { return bool(c.micro_lens_grid); })
      .def_property_readonly("pinhole",
                             [](const PlenopticCamera& c) {
                               const PlenopticProjection p(c);
                               return py::make_tuple(p.FocalLengthPx(), p.c.x(), p.c.y());
                             })
      .def_property_readonly(
          "pinhole_z", [](const PlenopticCamera& c) { return PlenopticProjection(c).center_z(); })
      .def("project", &ProjectAll, py::arg("points"))
      .def("unproject", &UnprojectAll, py::arg("pixels"));
}

void BindFrames(py::module_* module) {
  py::class_<LightFieldFrame>(*module, "Frame")
      .def_property_readonly("time", [](const LightFieldFrame& f) { return Seconds(f.time_ns); })
      .def_property_readonly("image",
                             [](const py::object& self) {
                               return ViewOf(self.cast<const LightFieldFrame&>().image[0], self);
                             })
      .def_property_readonly("inverse_virtual_depth",
                             [](const py::object& self) {
                               return ViewOf(
                                   self.cast<const LightFieldFrame&>().inverse_virtual_depth, self);
                             })
      .def_property_readonly("sigma", [](const py::object& self) {
        return ViewOf(self.cast<const LightFieldFrame&>().sigma, self);
      });
  py::class_<LightField>(*module, "LightField")
      .def(py::init<const PlenopticCamera&, const std::optional<py::array>&, int>(),
           py::arg("camera"),
           py::arg("white") = py::none(),
           py::arg("threads") = 0)
      .def("process", &LightField::Process, py::arg("image"), py::arg("time") = 0.0);
  py::class_<Sequence>(*module, "Sequence")
      .def(py::init([](const std::string& folder,
                       const std::string& camera,
                       const std::string& micro_lens_grid,
                       double rate_hz,
                       int max_frames) {
             SequenceOptions options;
             options.sequence = folder;
             options.camera = camera;
             options.micro_lens_grid = micro_lens_grid;
             options.rate_hz = rate_hz;
             options.max_frames = max_frames;
             return std::make_unique<Sequence>(options);
           }),
           py::arg("folder"),
           py::arg("camera") = "",
           py::arg("micro_lens_grid") = "",
           py::arg("rate_hz") = 0.0,
           py::arg("max_frames") = 0)
      .def_property_readonly("camera", &Sequence::camera)
      .def_property_readonly("format", &Sequence::format)
      .def_property_readonly("report", &Sequence::input_report)
      .def("__len__", &Sequence::size)
      .def("__iter__", [](const py::object& self) { return self; })
      .def("__next__", [](Sequence& self) {
        std::optional<LightFieldFrame> frame;
        {
          const py::gil_scoped_release release;
          frame = self.Next();
        }
        if (!frame) throw py::stop_iteration();
        return std::move(*frame);
      });
}

void BindOdometry(py::module_* module) {
  py::class_<FrameResult>(*module, "FrameResult")
      .def_property_readonly("time", [](const FrameResult& r) { return Seconds(r.time_ns); })
      .def_property_readonly("status", [](const FrameResult& r) { return ToString(r.status); })
      .def_property_readonly("has_pose", [](const FrameResult& r) { return HasPose(r.status); })
      .def_readonly("is_keyframe", &FrameResult::is_keyframe)
      .def_readonly("segment", &FrameResult::segment)
      .def_readonly("residual_rms", &FrameResult::rms)
      .def_readonly("points_used", &FrameResult::points_used)
      .def_property_readonly("world_from_cam", [](const FrameResult& r) {
        return MatrixOf(r.state.pose().Inverse());
      });
  py::class_<PythonOdometry>(*module, "Odometry")
      .def(py::init<const PlenopticCamera&, std::optional<py::array>, int, int, int, std::string>(),
           py::arg("camera"),
           py::arg("white") = py::none(),
           py::arg("threads") = 2,
           py::arg("window_keyframes") = 8,
           py::arg("active_points") = 2000,
           py::arg("focused_image") = "chief_rays")
      .def("process",
           &PythonOdometry::Process,
           py::arg("image"),
           py::arg("inverse_virtual_depth"),
           py::arg("sigma"),
           py::arg("time"))
      .def("process_frame", &PythonOdometry::ProcessFrame, py::arg("frame"))
      .def("process_raw", &PythonOdometry::ProcessRaw, py::arg("image"), py::arg("time"))
      .def_property_readonly("trajectory", &PythonOdometry::TrajectoryRows)
      .def_property_readonly("keyframes", &PythonOdometry::KeyframeRows)
      .def_property_readonly("points", &PythonOdometry::Points)
      .def("write_trajectory", &PythonOdometry::Write, py::arg("path"));
}

}  // namespace
}  // namespace prism

PYBIND11_MODULE(prism, module) {
  module.doc() = "Metric visual odometry for focused plenoptic cameras";
  module.attr("__version__") = prism::kVersion;
  pybind11::register_exception<prism::InputError>(module, "InputError", PyExc_ValueError);
  prism::BindCamera(&module);
  prism::BindFrames(&module);
  prism::BindOdometry(&module);
  prism::BindEvaluation(&module);
  module.def(
      "read_trajectory",
      [](const std::string& path) { return prism::ArrayOf(prism::ReadTrajectory(path)); },
      pybind11::arg("path"));
}
