// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <gflags/gflags.h>
#include <opencv2/core/utility.hpp>

#include "prism/base/error.h"
#include "prism/base/format.h"
#include "prism/io/atomic_file.h"
#include "prism/io/camera_file.h"
#include "prism/io/map_file.h"
#include "prism/io/trajectory_file.h"
#include "prism/odometry/odometry.h"
#include "prism/report/live_view.h"
#include "prism/report/run_report.h"
#include "prism/run/sequence.h"
#include "tools/end_signals.h"
#include "tools/export_recorder.h"
#include "tools/periodic.h"
#include "tools/recalibrate_sequence.h"
#include "tools/report_recorder.h"
#include "tools/run_output.h"
#include "tools/run_record.h"
#include "tools/tool_main.h"
#include "tools/unreadable_frames.h"

DEFINE_string(
    sequence,
    "",
    "Folder of the sequence (raw, focused or TUM RGB-D layout), or a video of raw frames.");
DEFINE_string(
    camera,
    "",
    "Camera file; empty: camera.yaml or CameraModel.xml of the folder. For RGB-D input: the "
    "plenoptic camera to stand in for; empty: a Raytrix R5 with 16 mm lens.");
DEFINE_string(micro_lens_grid,
              "",
              "Raytrix RayCalibData file, if the camera file has no grid; empty: "
              "MLA_Calibration.xml of the folder.");
DEFINE_double(rate_hz,
              0,
              "Frames a second of raw frames without a list; 0: times in their names, else 10, or "
              "as their video says.");
DEFINE_string(pinhole,
              "",
              "Camera of RGB-D input, fx,fy,cx,cy[,k1,k2,p1,p2[,k3]] in px, freiburg1, freiburg2, "
              "freiburg3 or ros_default; empty: calibration.txt of the folder.");
DEFINE_double(depth_factor, 5000, "Values of the depth images of RGB-D input a metre.");
DEFINE_string(white_image,
              "",
              "White image of a raw sequence; empty: white.png of the folder, else found on the "
              "frames; none: frames are taken as they are.");
DEFINE_string(colour,
              "auto",
              "Of raw frames: auto, gray, colour, bayer_rggb, _bggr, _grbg, _gbrg.");
DEFINE_string(focused_image,
              "chief_rays",
              "What raw and focused frames are turned into: images of chief_rays, which depth "
              "taken wrongly does not displace, or of virtual_points.");
DEFINE_bool(focus_colour,
            false,
            "Points in colour, of colour and Bayer raw frames; takes three focused images more.");
DEFINE_string(format, "", "raw, focused or rgbd; empty: by what the folder holds.");
DEFINE_string(output_dir, "", "Folder for the results; created if missing.");
DEFINE_string(
    groundtruth,
    "",
    "Trajectory (TUM) to evaluate against; empty: groundtruth.txt of the sequence, if there.");
DEFINE_bool(skip_missing,
            false,
            "A file of a list that is missing is a frame that cannot be read, not an error.");
DEFINE_int32(start_frame, 0, "First frame of the sequence to use.");
DEFINE_int32(max_frames, 0, "Number of frames to use; 0: all.");
DEFINE_bool(reverse, false, "Plays the frames backwards; the results have the times of the file.");
DEFINE_int32(ping_pong,
             0,
             "Passes through the sequence, forwards and backwards in turn, times going on to rise; "
             "0: one.");
DEFINE_int32(threads,
             2,
             "Threads of the optimisation and of raw frames. The result does not depend on it.");
DEFINE_uint64(seed, 0, "Seed of everything random.");
DEFINE_double(rgbd_inverse_depth_sigma, 0.004, "Noise added to 1/v of RGB-D input; 0: clean.");
DEFINE_int32(window_keyframes, 8, "Keyframes optimised together.");
DEFINE_int32(active_points, 2000, "Points in the sliding window.");
DEFINE_int32(iterations, 10, "Iterations of a window optimisation that does not converge before.");
DEFINE_double(photometric_model_sigma,
              3.5,
              "Photometric error beside the measured image noise, 0 to 255.");
DEFINE_bool(depth_residual,
            true,
            "Inverse virtual depth residuals; false is the ablation without.");
DEFINE_bool(keyframe_depth_offset,
            true,
            "An offset of each keyframe's 1/v is estimated; false: there is none.");
DEFINE_double(depth_offset_sigma,
              0,
              "Standard deviation of a lasting offset of measured 1/v, which is then estimated; 0: "
              "there is none.");
DEFINE_bool(refine_camera,
            false,
            "Before the run b_L0 is found on the sequence itself, in some passes (as "
            "prism_calibrate --recalibrate does); refined_camera.yaml is written.");
DEFINE_bool(marginalization_prior,
            true,
            "Prior from what left the window; false: it is forgotten.");
DEFINE_bool(first_estimate_jacobians, true, "Frames in the prior keep their linearisation point.");
DEFINE_bool(affine_brightness, true, "Affine brightness (a, b) of each frame; false: held at 0.");
DEFINE_bool(robust_loss, true, "Robust losses of all residuals; false: squares.");
DEFINE_bool(
    close_loops,
    false,
    "Looks for places seen before all the time, and writes what the trajectory, keyframes and "
    "points are with these loops closed beside the odometry's own (*_closed.*).");
DEFINE_bool(
    join_segments,
    true,
    "After a loss, places seen before are looked for; false: a new segment stays on its own.");
DEFINE_string(map, "", "Folder of a map saved by an earlier run, to find this one in.");
DEFINE_string(save_map, "", "Folder to save the map of this run to, for later runs.");
DEFINE_int32(map_places, 200, "Views that are kept to be found again.");
DEFINE_string(export,
              "",
              "Comma list of formats to write the run in beside ours: colmap, nerfstudio, kitti, "
              "euroc, mcap, ply, dense.");
DEFINE_int32(live, 0, "Port to show the run on in a browser while it goes on; 0: not shown.");
DEFINE_string(live_address, "127.0.0.1", "Address to serve --live on.");

namespace prism {
namespace {

// Null without --live.
std::unique_ptr<LiveView> StartLiveView(const RunRecord& record) {
  if (FLAGS_live == 0) return nullptr;
  std::string error = "the port " + std::to_string(FLAGS_live);
  std::unique_ptr<LiveView> live;
  if (FLAGS_live > 0 && FLAGS_live < 65536) {
    live = LiveView::Start(FLAGS_live_address, FLAGS_live, DescribeRun(record), &error);
  }
  if (!live) throw InputError("--live", error, "a free port of this machine");
  std::cout << "live view: http://" << FLAGS_live_address << ":" << FLAGS_live << "/" << std::endl;
  return live;
}

OdometryOptions OptionsFromFlags() {
  RequireInRange("window_keyframes", FLAGS_window_keyframes, 3, 1000);
  RequireInRange("active_points", FLAGS_active_points, 50, 1e6);
  RequireInRange("iterations", FLAGS_iterations, 1, 1000);
  RequireInRange("photometric_model_sigma", FLAGS_photometric_model_sigma, 1e-3, 255);
  RequireInRange("depth_offset_sigma", FLAGS_depth_offset_sigma, 0, 0.5);
  RequireInRange("map_places", FLAGS_map_places, 2, 1e6);
  OdometryOptions options;
  options.window.max_keyframes = FLAGS_window_keyframes;
  options.window.max_points = FLAGS_active_points;
  options.window.solve.max_iterations = FLAGS_iterations;
  options.window.solve.threads = FLAGS_threads;
  options.photometric_model_sigma = FLAGS_photometric_model_sigma;
  options.default_terms.depth_residual = FLAGS_depth_residual;
  options.default_terms.depth_offset.per_keyframe = FLAGS_keyframe_depth_offset;
  options.default_terms.depth_offset.prior_sigma = FLAGS_depth_offset_sigma;
  options.window.marginalization_prior = FLAGS_marginalization_prior;
  options.window.graph.first_estimates = FLAGS_first_estimate_jacobians;
  options.window.graph.affine_brightness = FLAGS_affine_brightness;
  options.default_terms.robust_loss = FLAGS_robust_loss;
  options.tracker.alignment.level.affine_brightness = FLAGS_affine_brightness;
  options.tracker.alignment.level.robust = FLAGS_robust_loss;
  options.joining.close_loops = FLAGS_close_loops;
  options.joining.join = FLAGS_join_segments;
  options.joining.max_places = FLAGS_map_places;
  std::string error;
  if (!options.IsValid(&error)) throw InputError("command line", error, "valid options");
  return options;
}

SequenceOptions SequenceOptionsFromFlags() {
  RequireFlag("sequence", FLAGS_sequence, "the folder of a sequence");
  RequireFlag("output_dir", FLAGS_output_dir, "a folder for the results");
  SequenceOptions options;
  options.sequence = FLAGS_sequence;
  options.camera = FLAGS_camera;
  options.micro_lens_grid = FLAGS_micro_lens_grid;
  options.white_image = FLAGS_white_image;
  options.colour = FLAGS_colour;
  options.threads = FLAGS_threads;
  options.focus_colour = FLAGS_focus_colour;
  options.focused_image = FLAGS_focused_image;
  options.format = FLAGS_format;
  options.skip_missing = FLAGS_skip_missing;
  options.start_frame = FLAGS_start_frame;
  options.max_frames = FLAGS_max_frames;
  options.reverse = FLAGS_reverse;
  options.ping_pong = FLAGS_ping_pong;
  options.rgbd.inverse_depth_sigma = FLAGS_rgbd_inverse_depth_sigma;
  options.rgbd.seed = FLAGS_seed;
  options.rate_hz = FLAGS_rate_hz;
  options.pinhole = FLAGS_pinhole;
  options.depth_factor = FLAGS_depth_factor;
  return options;
}

// The ground truth asked for, the sequence's own, or nothing.
Trajectory ReadGroundTruth() {
  std::string path = FLAGS_groundtruth;
  if (path.empty()) {
    path = (std::filesystem::path(FLAGS_sequence) / "groundtruth.txt").string();
    if (!std::filesystem::exists(path)) return {};
  }
  return ReadTrajectory(path);
}

std::string ClockTime(double seconds) {
  const int whole = static_cast<int>(std::min(seconds, 359999.0));
  return whole < 3600 ? Format("%d:%02d", whole / 60, whole % 60)
                      : Format("%d:%02d h", whole / 3600, whole / 60 % 60);
}

void ShowProgress(const RunRecord& record, const FrameResult& frame, int total, double seconds) {
  static const bool is_terminal = isatty(STDOUT_FILENO) != 0;
  if (!is_terminal) return;
  const double fps = static_cast<double>(record.frames.size()) / seconds;
  const double left = static_cast<double>(total) - static_cast<double>(record.frames.size());
  std::printf("\rframe %zu/%d  %.1f fps  %s left  %d keyframes  %d points  %-12s",
              record.frames.size(),
              total,
              fps,
              ClockTime(left / fps).c_str(),
              CountKeyframes(record.frames),
              frame.active_points,
              ToString(frame.status));
  std::fflush(stdout);
}

// Nothing at the end of the sequence.
std::optional<FrameResult> ProcessNext(int number,
                                       Sequence* sequence,
                                       Odometry* odometry,
                                       UnreadableFrames* unreadable) {
  try {
    std::optional<LightFieldFrame> frame = sequence->Next();
    if (!frame) return std::nullopt;
    return odometry->Process(std::move(*frame));
  } catch (const UnreadableFrame& frame) {
    unreadable->Add(number, frame);
    return odometry->Skip(frame.time_ns);
  }
}

// What is known of a run at this moment, beside its frames.
void UpdateRecord(const Sequence& sequence, const Odometry& odometry, RunRecord* record) {
  record->light_field = sequence.Verdict();
  record->stages = sequence.timer().Summarize();
  record->stages.merge(odometry.timer().Summarize());
  record->trajectory = odometry.FrameTrajectory();
  record->piece_of_segment = odometry.map().PieceOfSegments();
  record->intensity_sigma = odometry.window().noise.ResidualSigma();
  record->depth_scale = odometry.window().noise.DepthScale();
  record->keyframe_depth_offset_sigma = odometry.window().noise.DepthOffsetSigma();
  record->depth_offset_prior_sigma = FLAGS_depth_offset_sigma;
}

// Results of a run that goes on, which a full disk does not end.
void WriteOnTheWay(const std::function<void()>& write) {
  static bool is_told = false;
  try {
    write();
  } catch (const InputError& error) {
    if (!is_told) std::cerr << "\nprism_vo: not written for now: " << error.what() << std::endl;
    is_told = true;
  }
}

// Images that were freed among what is kept leave holes in the heap of the GNU C library, which
// would grow as if nothing had been freed.
void ReturnFreeMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

ExitStatus Run() {
  const SequenceOptions sequence_options = SequenceOptionsFromFlags();
  const OdometryOptions odometry_options = OptionsFromFlags();
  ExportRecorder exports(FLAGS_export);
  Sequence sequence(sequence_options);  // looks at --threads as well
  cv::setNumThreads(FLAGS_threads);
  std::cout << sequence.format() << " frames of " << FLAGS_sequence << "\n";
  for (const std::string& line : sequence.input_report()) std::cout << "  " << line << "\n";
  for (const std::string& note : sequence.notes()) std::cout << "  " << note << "\n";
  const PlenopticCamera camera =
      FLAGS_refine_camera ? RecalibrateSequence(sequence_options, {odometry_options}).camera
                          : sequence.camera();
  const Trajectory groundtruth = sequence.play_order().AsPlayed(ReadGroundTruth());
  std::vector<MappedPlace> places;
  if (!FLAGS_map.empty()) places = ReadMap(FLAGS_map, PlenopticProjection(camera));
  if (!FLAGS_save_map.empty()) RequireWritableFolder(FLAGS_save_map);
  RequireWritableFolder(FLAGS_output_dir);

  RunRecord record;
  record.options = EffectiveOptions();
  record.camera_path = sequence.camera_path();
  record.camera = camera;
  record.sequence_format = sequence.format();
  record.input_report = sequence.input_report();
  record.notes = sequence.notes();
  ReportRecorder recorder;
  const std::unique_ptr<LiveView> live = StartLiveView(record);
  const EndSignals signals;
  ClearResults(FLAGS_output_dir);
  const double processor_start = ProcessorSeconds();
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  Odometry odometry(camera, odometry_options);
  if (!FLAGS_map.empty()) odometry.LoadPlaces(places);
  UnreadableFrames unreadable(FLAGS_sequence, sequence.size());
  const auto update_record = [&] {
    UpdateRecord(sequence, odometry, &record);
    record.unreadable = unreadable.reasons();
    record.wall_seconds = seconds();
    record.processor_seconds = ProcessorSeconds() - processor_start;
  };
  Periodic write_poses([&] {
    WriteOnTheWay([&] { WritePoses(FLAGS_output_dir, odometry, sequence.play_order()); });
  });
  Periodic write_all([&] {
    update_record();
    WriteOnTheWay([&] { WriteRun(FLAGS_output_dir, record, odometry, sequence.play_order()); });
    ReturnFreeMemory();
  });
  std::exception_ptr failure;
  bool is_verdict_told = sequence.format() != "raw";
  try {
    while (signals.received() == 0) {
      const int number = static_cast<int>(record.frames.size());
      std::optional<FrameResult> result = ProcessNext(number, &sequence, &odometry, &unreadable);
      if (!result) break;
      if (!is_verdict_told && result->status != FrameStatus::kUnreadable) {
        std::cout << sequence.Verdict().Text() << std::flush;
        is_verdict_told = true;
      }
      record.frames.push_back(std::move(*result));
      recorder.Add(record.frames.back(), odometry, sequence.timer());
      exports.Add(record.frames.back(), odometry);
      if (live) live->Publish(recorder.TakeUpdate());
      ShowProgress(record, record.frames.back(), sequence.size(), seconds());
      write_poses.Tick();
      write_all.Tick();
    }
    record.end = signals.received() == 0 ? "complete" : "interrupted";
    if (signals.received() != 0) record.end_reason = signals.Name();
  } catch (const std::exception& error) {
    record.end = "failed";
    record.end_reason = error.what();
    failure = std::current_exception();
  }
  update_record();
  if (failure && CountTracked(record.frames) == 0) {
    ClearResults(FLAGS_output_dir);
    std::rethrow_exception(failure);
  }

  WriteRun(FLAGS_output_dir, record, odometry, sequence.play_order());
  PrintRun(FLAGS_output_dir, record, odometry);
  if (FLAGS_refine_camera) {
    WriteNativeCamera((std::filesystem::path(FLAGS_output_dir) / "refined_camera.yaml").string(),
                      camera);
  }
  std::cout << exports.Write(FLAGS_output_dir, odometry, sequence.play_order()) << std::flush;
  if (FLAGS_close_loops)
    WriteClosedMap(FLAGS_output_dir, odometry, sequence.play_order(), groundtruth);
  if (!FLAGS_save_map.empty()) SaveMap(FLAGS_save_map, odometry);
  if (!groundtruth.empty()) WriteMetrics(FLAGS_output_dir, record, odometry, groundtruth);
  RunUpdate end;
  if (live) end = recorder.TakeUpdate(/*is_last=*/true);
  const auto report =
      std::make_shared<const RunReport>(std::move(recorder).Finish(record, odometry, groundtruth));
  WriteReport((std::filesystem::path(FLAGS_output_dir) / "report.html").string(), *report);
  if (live) {
    end.finished = report;
    live->Publish(std::move(end));
  }
  PrintEnd(record);
  if (failure) std::rethrow_exception(failure);
  if (signals.received() != 0) return static_cast<ExitStatus>(signals.ExitStatus());
  const int tracked = CountTracked(record.frames);
  const bool is_most = 2 * tracked >= static_cast<int>(record.frames.size());
  return tracked > 0 && is_most ? kExitDone : kExitRunFailed;
}

}  // namespace
}  // namespace prism

int main(int argc, char** argv) {
  return prism::RunTool(
      {"prism_vo",
       "metric visual odometry from plenoptic frames",
       "--sequence=DIR --camera=FILE --output_dir=DIR [flags]",
       "prism_vo --sequence=my_sequence --camera=calib/raytrix_r5_16mm.yaml --output_dir=out"},
      argc,
      argv,
      prism::Run);
}
