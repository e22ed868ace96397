// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// A camera's metric figures from pictures of a board.
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <string>

#include <gflags/gflags.h>

#include "prism/base/error.h"
#include "prism/base/version.h"
#include "prism/calibration/board_observation.h"
#include "prism/calibration/calibrate.h"
#include "prism/calibration/micro_image_views.h"
#include "prism/io/camera_file.h"
#include "prism/io/focused_sequence.h"
#include "prism/io/frame_files.h"
#include "prism/io/image_file.h"
#include "prism/io/micro_image_corners.h"
#include "prism/lightfield/light_field_processor.h"
#include "prism/run/micro_lens_estimation.h"
#include "prism/run/raw_input.h"
#include "tools/board_pdf.h"
#include "tools/calibration_report.h"
#include "tools/recalibrate_sequence.h"
#include "tools/tool_main.h"

DEFINE_string(
    sequence,
    "",
    "Folder of pictures of the board, raw (raw.txt or just images) or focused (focused.txt).");
DEFINE_string(micro_image_corners,
              "",
              "Instead of pictures: CSV of corners in micro images (k,l,u,v,cluster,frame).");
DEFINE_string(micro_image_centers, "", "With it: CSV of the micro images' centres (k,l,u,v).");
DEFINE_string(board, "charuco", "charuco or checkerboard.");
DEFINE_string(squares, "9x6", "Squares in a row x in a column, the outer ones counted.");
DEFINE_double(square_mm, 40, "Side of a square, as measured on the board.");
DEFINE_string(write_board, "", "Only write the board to print to this PDF file.");
DEFINE_string(camera,
              "",
              "Camera file to start from: sizes, grid, f_L. Empty: --focal_length_mm and "
              "--pixel_size_mm say enough.");
DEFINE_double(focal_length_mm, 0, "What is engraved on the lens; 0: that of --camera is a guess.");
DEFINE_double(pixel_size_mm, 0, "Of the sensor, where there is no --camera.");
DEFINE_string(image_size_px,
              "",
              "Of the raw image, such as 2048x2048, where neither --camera nor pictures say it.");
DEFINE_bool(hold_focal_length, false, "f_L stays as it is given.");
DEFINE_double(sensor_mla_distance_mm, 0, "B, where it is known: it is held. 0: it is found.");
DEFINE_string(distortion, "auto", "auto (what the pictures carry), none, radial or full.");
DEFINE_bool(recalibrate,
            false,
            "b_L0 from any moving sequence instead of pictures of a board, with f_L and B of "
            "--camera held.");
DEFINE_int32(max_frames, 0, "With --recalibrate: frames of the sequence; 0: all.");
DEFINE_string(micro_lens_grid, "", "Raytrix RayCalibData file, if the camera file has no grid.");
DEFINE_string(white_image,
              "",
              "White image; empty: white.png of the folder, else found on the frames; none: frames "
              "are taken as they are.");
DEFINE_string(colour, "auto", "auto, gray, colour, bayer_rggb, _bggr, _grbg or _gbrg.");
DEFINE_string(output_dir, "", "Folder for the results; created if missing.");
DEFINE_int32(threads, 2, "Threads; 0: one a core. The result does not depend on it.");

namespace prism {
namespace {

namespace fs = std::filesystem;

// "9x6"
std::array<int, 2> ParseSize(const std::string& flag, const std::string& text) {
  std::array<int, 2> size{};
  int used = 0;
  if (std::sscanf(text.c_str(), "%dx%d%n", &size[0], &size[1], &used) != 2 ||
      used != static_cast<int>(text.size())) {
    throw InputError(flag, "'" + text + "'", "two numbers, such as 9x6");
  }
  return size;
}

CalibrationBoard ReadBoard() {
  CalibrationBoard board;
  if (!ParseBoardPattern(FLAGS_board, &board.pattern)) {
    throw InputError("--board", "'" + FLAGS_board + "'", "charuco or checkerboard");
  }
  const std::array<int, 2> squares = ParseSize("--squares", FLAGS_squares);
  board.columns = squares[0];
  board.rows = squares[1];
  board.square_m = 1e-3 * FLAGS_square_mm;
  std::string error;
  if (!board.IsValid(&error)) throw InputError("--squares, --square_mm", error, "a board");
  return board;
}

CalibrateOptions ReadOptions() {
  CalibrateOptions options;
  options.focal_length_is_known = FLAGS_focal_length_mm > 0;
  options.hold_focal_length = FLAGS_hold_focal_length;
  options.hold_sensor_distance = FLAGS_sensor_mla_distance_mm > 0;
  options.sensor_distance_is_known = !FLAGS_camera.empty();
  if (!ParseDistortionModel(FLAGS_distortion, &options.distortion)) {
    throw InputError("--distortion", "'" + FLAGS_distortion + "'", "auto, none, radial or full");
  }
  return options;
}

// What flags say of the lens goes before what the file says.
void ApplyLensFlags(PlenopticCamera* camera) {
  const double steps =
      (camera->focal_length - camera->main_lens_mla_distance) / camera->sensor_mla_distance;
  if (FLAGS_focal_length_mm > 0) camera->focal_length = 1e-3 * FLAGS_focal_length_mm;
  if (FLAGS_sensor_mla_distance_mm > 0) {
    camera->sensor_mla_distance = 1e-3 * FLAGS_sensor_mla_distance_mm;
  }
  camera->main_lens_mla_distance = camera->focal_length - steps * camera->sensor_mla_distance;
}

// A camera by what an owner knows of it: f_L and pixel size. B and b_L0 are those of a Raytrix
// camera, near enough to start from.
PlenopticCamera CameraFromFlags(std::array<int, 2> size) {
  if (!(FLAGS_focal_length_mm > 0) || !(FLAGS_pixel_size_mm > 0)) {
    throw InputError(
        "--camera", "nothing", "a camera file, or --focal_length_mm and --pixel_size_mm");
  }
  constexpr double kTypicalInfinityDepth = 2.3;
  PlenopticCamera camera;
  camera.raw_width = size[0];
  camera.raw_height = size[1];
  camera.raw_pixel_size = 1e-3 * FLAGS_pixel_size_mm;
  camera.focal_length = 1e-3 * FLAGS_focal_length_mm;
  camera.sensor_mla_distance =
      FLAGS_sensor_mla_distance_mm > 0 ? 1e-3 * FLAGS_sensor_mla_distance_mm : 0.4e-3;
  camera.main_lens_mla_distance =
      camera.focal_length - kTypicalInfinityDepth * camera.sensor_mla_distance;
  camera.raw_principal_point = {0.5 * (size[0] - 1), 0.5 * (size[1] - 1)};
  std::string error;
  if (!camera.IsValid(&error)) throw InputError("command line", error, "a camera");
  return camera;
}

std::array<int, 2> FirstImageSize(const std::string& folder) {
  const cv::Mat image = ReadImageUnchanged(FindFrameFiles(folder, 0).frames.front().path);
  return {image.cols, image.rows};
}

RawInputOptions InputOptions(const std::string& camera) {
  RawInputOptions options;
  options.folder = FLAGS_sequence;
  options.camera = camera;
  options.micro_lens_grid = FLAGS_micro_lens_grid;
  options.white_image = FLAGS_white_image;
  options.colour = FLAGS_colour;
  options.threads = FLAGS_threads;
  // Corners stay where they are, whatever the depths and the camera the images are made with.
  options.focused_image = FocusedImage::kChiefRays;
  return options;
}

// --camera, or a file made of the flags and of what the pictures show of the micro lenses.
std::string StartCameraFile() {
  if (!FLAGS_camera.empty()) return FLAGS_camera;
  const std::array<int, 2> size = FLAGS_image_size_px.empty()
                                      ? FirstImageSize(FLAGS_sequence)
                                      : ParseSize("--image_size_px", FLAGS_image_size_px);
  std::string path = (fs::path(FLAGS_output_dir) / "start_camera.yaml").string();
  fs::create_directories(FLAGS_output_dir);
  WriteNativeCamera(path, CameraFromFlags(size));
  if (FLAGS_micro_lens_grid.empty()) {
    WriteNativeCamera(path, EstimateMicroLenses(InputOptions(path)).camera);
  }
  return path;
}

struct Pictures {
  std::vector<BoardView> views;
  PlenopticCamera camera;
  std::string report;
};

Pictures ReadMicroImages(const CalibrationBoard& board) {
  RequireFlag("micro_image_centers", FLAGS_micro_image_centers, "the centres of the micro images");
  Pictures pictures;
  pictures.views = ViewsFromMicroImages(
      board, ReadMicroImageCorners(FLAGS_micro_image_corners, FLAGS_micro_image_centers));
  if (FLAGS_camera.empty()) {
    RequireFlag("image_size_px", FLAGS_image_size_px, "the size of the raw image, or --camera");
    pictures.camera = CameraFromFlags(ParseSize("--image_size_px", FLAGS_image_size_px));
  } else {
    pictures.camera = ReadPlenopticCamera(FLAGS_camera);
  }
  const bool keplerian = IsKeplerian(pictures.views);
  if (keplerian != (pictures.camera.mode == MicroLensMode::kKeplerian)) {
    if (!FLAGS_camera.empty()) {
      throw InputError(FLAGS_camera,
                       "mode " + std::string(ToString(pictures.camera.mode)),
                       keplerian ? "keplerian, as the micro images are upside down"
                                 : "galilean, as the micro images are not upside down");
    }
    pictures.camera.mode = MicroLensMode::kKeplerian;
    pictures.camera.main_lens_mla_distance =
        2 * pictures.camera.focal_length - pictures.camera.main_lens_mla_distance;
  }
  return pictures;
}

Pictures ReadRawPictures(const CalibrationBoard& board) {
  RawInput input = OpenRawInput(InputOptions(StartCameraFile()));
  Pictures pictures;
  pictures.camera = input.camera;
  pictures.camera.focused_image =
      FocusedImage::kVirtualPoints;  // as camera files of raw frames say
  pictures.report = input.grid_report;
  LightFieldProcessor processor(input.camera, input.white, input.options);
  for (int i = 0; i < input.sequence->size(); ++i) {
    const RawFrame raw = input.sequence->Read(i);
    const LightFieldFrame frame = processor.Process(raw);
    BoardView view =
        ObserveBoard(board, input.camera, frame, processor.dense_inverse_virtual_depth());
    view.name = fs::path(raw.path).filename().string();
    std::printf(
        "%s: %zu of %d corners\n", view.name.c_str(), view.corners.size(), board.num_corners());
    std::fflush(stdout);
    pictures.views.push_back(std::move(view));
  }
  return pictures;
}

Pictures ReadFocusedPictures(const CalibrationBoard& board) {
  RequireFlag("camera", FLAGS_camera, "the camera file the focused images were made with");
  Pictures pictures;
  pictures.camera = ReadPlenopticCamera(FLAGS_camera);
  const FocusedSequence sequence(FLAGS_sequence, pictures.camera);
  for (int i = 0; i < sequence.size(); ++i) {
    BoardView view = ObserveBoard(board, pictures.camera, sequence.Read(i), ImageF());
    view.name = FrameFileName(i);
    pictures.views.push_back(std::move(view));
  }
  return pictures;
}

Pictures ReadPictures(const CalibrationBoard& board) {
  if (!FLAGS_micro_image_corners.empty()) return ReadMicroImages(board);
  Pictures pictures =
      IsFocusedSequence(FLAGS_sequence) ? ReadFocusedPictures(board) : ReadRawPictures(board);
  const bool any = std::any_of(pictures.views.begin(), pictures.views.end(), [](const auto& view) {
    return !view.corners.empty();
  });
  if (!any) {
    throw InputError(FLAGS_sequence,
                     "no " + FLAGS_board + " board of " + FLAGS_squares + " squares",
                     "pictures of it (--board, --squares)");
  }
  return pictures;
}

ExitStatus WriteBoard(const CalibrationBoard& board) {
  WriteBoardPdf(FLAGS_write_board, board);
  std::cout << "board: " << FLAGS_write_board << std::endl;
  return kExitDone;
}

ExitStatus RecalibrateOnly() {
  RequireFlag("sequence", FLAGS_sequence, "a folder of a moving sequence");
  RequireFlag("camera", FLAGS_camera, "the camera file to mend");
  RequireFlag("output_dir", FLAGS_output_dir, "a folder for the results");
  SequenceOptions options;
  options.sequence = FLAGS_sequence;
  options.camera = FLAGS_camera;
  options.micro_lens_grid = FLAGS_micro_lens_grid;
  options.white_image = FLAGS_white_image;
  options.colour = FLAGS_colour;
  options.threads = FLAGS_threads;
  options.max_frames = FLAGS_max_frames;
  const RecalibrationResult result = RecalibrateSequence(options, RecalibrationOptions());
  fs::create_directories(FLAGS_output_dir);
  const std::string path = (fs::path(FLAGS_output_dir) / "camera.yaml").string();
  WriteNativeCamera(path, result.camera);
  std::cout << "written to " << path << std::endl;
  return kExitDone;
}

ExitStatus Run() {
  const CalibrationBoard board = ReadBoard();
  if (!FLAGS_write_board.empty()) return WriteBoard(board);
  if (FLAGS_recalibrate) return RecalibrateOnly();
  if (FLAGS_micro_image_corners.empty()) {
    RequireFlag("sequence", FLAGS_sequence, "a folder of pictures of the board");
  }
  RequireFlag("output_dir", FLAGS_output_dir, "a folder for the results");
  const CalibrateOptions options = ReadOptions();
  const Pictures pictures = ReadPictures(board);
  PlenopticCamera start = pictures.camera;
  ApplyLensFlags(&start);
  const CalibrationResult result = Calibrate(board, pictures.views, start, options);
  if (!pictures.report.empty()) std::cout << pictures.report << "\n";
  const CalibrationReport report = MakeCalibrationReport(board, result);
  std::cout << report.text << std::flush;
  if (!result.problem.empty()) {
    throw InputError(FLAGS_sequence.empty() ? FLAGS_micro_image_corners : FLAGS_sequence,
                     result.problem,
                     "pictures that determine the camera");
  }
  fs::create_directories(FLAGS_output_dir);
  const fs::path output(FLAGS_output_dir);
  WriteNativeCamera((output / "camera.yaml").string(), result.camera);
  if (result.camera.focused_scale == 2) {
    WriteLifcalCamera((output / "CameraModel.xml").string(), result.camera);
  }
  WriteCalibrationReport(FLAGS_output_dir, board, result, report);
  std::cout << "results in " << FLAGS_output_dir << std::endl;
  return kExitDone;
}

}  // namespace
}  // namespace prism

int main(int argc, char** argv) {
  return prism::RunTool(
      {"prism_calibrate",
       "finds a plenoptic camera's metric figures on pictures of a board.",
       "--sequence=FOLDER --camera=FILE --output_dir=FOLDER [--squares=9x6] [--square_mm=40]\n"
       "       prism_calibrate --micro_image_corners=FILE --micro_image_centers=FILE "
       "--camera=FILE --output_dir=FOLDER\n"
       "       prism_calibrate --recalibrate --sequence=FOLDER --camera=FILE --output_dir=FOLDER\n"
       "       prism_calibrate --write_board=board.pdf [--squares=9x6] [--square_mm=40]",
       "prism_calibrate --sequence=board_pictures --camera=calib/raytrix_r5_16mm.yaml "
       "--output_dir=out/calibration"},
      argc,
      argv,
      prism::Run);
}
