// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/run/micro_lens_estimation.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "prism/base/error.h"
#include "prism/base/format.h"
#include "prism/io/camera_file.h"
#include "prism/io/raw_sequence.h"
#include "prism/lightfield/camera_trial.h"
#include "prism/lightfield/grid_estimation.h"
#include "prism/lightfield/lens_type_estimation.h"
#include "prism/lightfield/vignetting.h"
#include "prism/lightfield/with_threads.h"

namespace prism {
namespace {

constexpr double kRightAngle = 0.25;  // cosine between base vectors of a square array, at most

bool IsSquare(const MicroLensGrid& grid) {
  return std::abs(grid.base_x.dot(grid.base_y)) < kRightAngle;
}

void FindMode(const cv::Mat& white,
              const LightFieldOptions& options,
              const RawFrame& frame,
              MicroLensEstimate* estimate) {
  PlenopticCamera galilean = estimate->camera;
  galilean.mode = MicroLensMode::kGalilean;
  PlenopticCamera keplerian = estimate->camera;
  keplerian.mode = MicroLensMode::kKeplerian;
  const double upright = TryCamera(galilean, white, options, frame).measured;
  const double upside_down = TryCamera(keplerian, white, options, frame).measured;
  estimate->camera = upside_down > upright ? keplerian : galilean;
  estimate->report +=
      Format("mode %s: depth at %.1f %% of the first frame's pixels, as %s %.1f %%\n",
             ToString(estimate->camera.mode),
             100 * std::max(upright, upside_down),
             ToString(upside_down > upright ? galilean.mode : keplerian.mode),
             100 * std::min(upright, upside_down));
}

void FindTypes(const cv::Mat& white,
               const LightFieldOptions& options,
               const std::vector<RawFrame>& frames,
               MicroLensEstimate* estimate) {
  if (IsSquare(*estimate->camera.micro_lens_grid)) {
    estimate->report += "one lens type, as in all square arrays\n";
    return;
  }
  const LensTypeFit fit = EstimateLensTypes(estimate->camera, white, options, frames);
  estimate->camera.micro_lens_grid->types = fit.types;
  if (fit.types.size() == 1) {
    estimate->report += Format(
        "one lens type: three would be told by the frames' depths (best over worst order %.2f)\n",
        fit.evidence);
    return;
  }
  estimate->report +=
      Format("three lens types (the frames' depths, best over worst order %.2f)\n", fit.evidence);
  if (fit.focus_measured) {
    estimate->report += Format("  sharpest at 1/v = %.3f, %.3f and %.3f, known to %.3f\n",
                               fit.focus[0],
                               fit.focus[1],
                               fit.focus[2],
                               fit.focus_sigma);
  } else {
    estimate->report +=
        "  what each is focused on is assumed: the frames hold too few different depths\n";
  }
}

}  // namespace

MicroLensEstimate EstimateMicroLenses(const RawInputOptions& options) {
  MicroLensEstimate estimate{ReadPlenopticCamera(options.camera), ""};
  const LightFieldOptions light_field = LightFieldOptionsOf(options);
  std::vector<RawFrame> frames;
  std::string white_path = options.white_image;
  if (!options.folder.empty()) {
    const RawSequence sequence(options.folder, estimate.camera);
    frames = sequence.ReadSome(kFramesToLookAt);
    if (white_path.empty()) white_path = sequence.WhiteImagePath();
  }
  const bool has_white = !white_path.empty() && white_path != kNoWhiteImage;
  if (!has_white && frames.empty()) {
    throw InputError("command line", "neither a white image nor raw frames", "one of them");
  }
  cv::Mat white;
  if (has_white) white = ReadWhiteImage(white_path, estimate.camera);
  const std::string source = has_white ? white_path : options.folder;
  WithThreads(options.threads, [&] {
    const std::optional<GridFit> fit = has_white
                                           ? EstimateGrid(MeanImage({white}))
                                           : EstimateGridOnFrames(MeanImage(ImagesOf(frames)));
    if (!fit) {
      throw InputError(source,
                       "no pattern of micro images",
                       "a hexagonal or square one with a pitch of 6 to 120 px");
    }
    const MicroLensGrid& grid = fit->grid;
    estimate.camera.micro_lens_grid = grid;
    estimate.report += Format(
        "%s array: %d micro images, pitch %.5f px, rotation %.6f rad, offset (%.4f, %.4f) px, RMS "
        "%.4f px\n",
        IsSquare(grid) ? "square" : "hexagonal",
        fit->lenses,
        grid.diameter_px,
        grid.rotation,
        grid.offset_px.x(),
        grid.offset_px.y(),
        fit->rms_px);
  });
  if (frames.empty()) {
    estimate.report +=
        "mode and lens types are not known without raw frames: as in the camera "
        "file, and one\n";
    return estimate;
  }
  if (white.empty() && white_path != kNoWhiteImage) {
    const std::optional<Vignetting> vignetting = WithThreads(options.threads, [&] {
      return EstimateVignetting(LensTable(estimate.camera), ImagesOf(frames));
    });
    if (vignetting && vignetting->IsNeeded()) white = vignetting->white;
  }
  FindMode(white, light_field, frames[0], &estimate);
  FindTypes(white, light_field, frames, &estimate);
  return estimate;
}

}  // namespace prism
