// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/run/camera_decisions.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include <glog/logging.h>

#include "prism/base/error.h"
#include "prism/base/format.h"
#include "prism/io/raw_sequence.h"
#include "prism/lightfield/camera_trial.h"
#include "prism/lightfield/grid_estimation.h"
#include "prism/lightfield/vignetting.h"
#include "prism/lightfield/with_threads.h"

namespace prism {
namespace {

constexpr double kMaxRms = 0.05;  // of a micro-image centre, in pitches
constexpr double kMinContrastOfWhite = 0.05;
constexpr double kMinContrastOfFrames = 0.1;  // below that they do not show the grid
// Relative. Refocusing the main lens moves the pitch by some 0.1 %; more is another camera's grid.
constexpr double kMaxPitchChange = 0.003;
// In pitches: a lattice that has to move farther than this somewhere is not the one of the images,
// but another near by. Real files are off by a twentieth.
constexpr double kMaxMove = 0.3;
constexpr double kCertainRms = 0.5;  // px; above, what the frames show has moved the grid as well
constexpr double kSmallRotation = 0.5;  // px at the image border
constexpr double kManyDepths = 0.25;    // of the pixels: upside-down images gave up to 0.14
constexpr double kFewDepths = 0.03;
constexpr double kMinMoreDepths = 2;  // times as many in the other mode

[[noreturn]] void ThrowGridDoesNotFit(const std::string& grid_path,
                                      const MicroLensGrid& grid,
                                      const std::string& source,
                                      const std::optional<GridFit>& seen) {
  char found[128];
  std::snprintf(found, sizeof(found), "a micro-lens pitch of %.4f px", grid.diameter_px);
  char expected[128] = "the grid";
  if (seen) {
    std::snprintf(expected,
                  sizeof(expected),
                  "%.4f px to %.1f %%, the pitch",
                  seen->grid.diameter_px,
                  100 * kMaxPitchChange);
  }
  throw InputError(grid_path, found, std::string(expected) + " of the " + source);
}

// Grids to choose from, best founded first, and what is said of the choice.
struct GridCandidate {
  MicroLensGrid grid;
  std::string report;
};

// The grid refined on the white image, or on the frames where there is none; as it is filed, with
// either sign of its rotation, where that is not certain.
std::vector<GridCandidate> FindGrids(const std::string& grid_path,
                                     const std::vector<RawFrame>& frames,
                                     const RawInput& input) {
  const bool has_white = !input.white.empty();
  const ImageF image = MeanImage(has_white ? std::vector<cv::Mat>{input.white} : ImagesOf(frames));
  const MicroLensGrid& grid = *input.camera.micro_lens_grid;
  const std::optional<GridFit> fit =
      has_white ? RefineGrid(image, grid) : RefineGridOnFrames(image, grid);
  const char* source = has_white ? "white image" : "raw frames";
  const bool fits = fit && fit->rms_px < kMaxRms * grid.diameter_px &&
                    fit->contrast > (has_white ? kMinContrastOfWhite : kMinContrastOfFrames);
  if (!fits && has_white) ThrowGridDoesNotFit(grid_path, grid, source, EstimateGrid(image));
  std::vector<GridCandidate> candidates;
  if (fits) {
    if (std::abs(fit->grid.diameter_px / grid.diameter_px - 1) > kMaxPitchChange) {
      ThrowGridDoesNotFit(grid_path, grid, source, fit);
    }
    if (!fit->rotation_flipped && fit->max_change_px > kMaxMove * grid.diameter_px) {
      throw InputError(
          grid_path,
          Format(
              "micro images up to %.1f px from where the %s have them", fit->max_change_px, source),
          Format("the grid of this camera, good to %.1f px", kMaxMove * grid.diameter_px));
    }
    candidates.push_back(
        {fit->grid,
         Format("micro-lens grid refined on the %s: %d micro images, RMS %.3f px, moved by at most "
                "%.3f px, pitch %.4f px, rotation %.6f rad%s",
                source,
                fit->lenses,
                fit->rms_px,
                fit->max_change_px,
                fit->grid.diameter_px,
                fit->grid.rotation,
                fit->rotation_flipped ? " (opposite sign to the file's)" : "")});
    if (has_white || fit->rms_px < kCertainRms) return candidates;
  }
  const std::string why =
      Format(": the %s do not show it well enough to refine it (contrast %.2f, RMS %.2f px)",
             source,
             fit ? fit->contrast : 0.0,
             fit ? fit->rms_px : 0.0);
  candidates.push_back({grid, "micro-lens grid kept as it is" + why});
  const double half_size = 0.5 * std::max(image.width(), image.height());
  if (std::abs(grid.rotation) * half_size > kSmallRotation) {
    MicroLensGrid turned = grid;
    turned.rotation *= -1;
    candidates.push_back({turned, "micro-lens grid turned the other way" + why});
  }
  return candidates;
}

// Without a white image the frames say how their micro images are shaded.
cv::Mat FindVignetting(const PlenopticCamera& camera,
                       const std::vector<cv::Mat>& frames,
                       std::string* report) {
  std::optional<Vignetting> vignetting = EstimateVignetting(LensTable(camera), frames);
  if (!vignetting) {
    *report +=
        "; no white image, and too few micro images to tell the vignetting from: none is "
        "corrected";
    return {};
  }
  if (!vignetting->IsNeeded()) {
    *report += Format(
        "; no white image, and none needed: micro images are as bright at the rim (%.0f %% of "
        "their centre)",
        100 * vignetting->rim);
    return {};
  }
  *report +=
      Format("; no white image: vignetting found on %d micro images (rim at %.0f %% of the centre)",
             vignetting->micro_images,
             100 * vignetting->rim);
  return vignetting->white;
}

// Everything about the camera that files leave open and the first frame can tell, in the order in
// which one depends on the other.
class FirstFrameDecisions {
 public:
  // Of `frames` the first one decides; the vignetting is found on all of them, if it is to be.
  FirstFrameDecisions(const std::vector<RawFrame>& frames, bool find_vignetting, RawInput* input)
      : first_(frames.front()), input_(input) {
    if (find_vignetting) images_ = ImagesOf(frames);
  }

  void Decide(const std::vector<GridCandidate>& grids) {
    Choose(TryGrid(grids[0]));
    DecideMode();
    DecideGrid(grids);
    DecideTypeOrder();
  }

 private:
  struct Choice {
    PlenopticCamera camera;
    cv::Mat white;
    std::string report;
    CameraTrial trial;
  };

  CameraTrial Try(const PlenopticCamera& camera, const cv::Mat& white) const {
    return TryCamera(camera, white, input_->options, first_);
  }

  Choice TryGrid(const GridCandidate& candidate) const {
    Choice choice{input_->camera, input_->white, candidate.report, {}};
    choice.camera.micro_lens_grid = candidate.grid;
    if (!images_.empty()) choice.white = FindVignetting(choice.camera, images_, &choice.report);
    choice.trial = Try(choice.camera, choice.white);
    return choice;
  }

  void Choose(const Choice& choice) {
    input_->camera = choice.camera;
    input_->white = choice.white;
    input_->grid_report = choice.report;
    trial_ = choice.trial;
  }

  // Read in the wrong mode, micro images are upside down and lenses agree by chance only.
  void DecideMode() {
    if (trial_.measured > kManyDepths) return;
    PlenopticCamera other = input_->camera;
    other.mode = other.mode == MicroLensMode::kKeplerian ? MicroLensMode::kGalilean
                                                         : MicroLensMode::kKeplerian;
    const CameraTrial trial = Try(other, input_->white);
    if (trial.measured < std::max(kMinMoreDepths * trial_.measured, kFewDepths)) return;
    mode_report_ = Format(
        "; micro images are upside down for a %s camera and read as %s (depth at %.0f "
        "instead of %.0f %% of the pixels)",
        ToString(input_->camera.mode),
        ToString(other.mode),
        100 * trial.measured,
        100 * trial_.measured);
    LOG(WARNING) << "the camera file says 'mode: " << ToString(input_->camera.mode)
                 << "', the frames are " << ToString(other.mode)
                 << ": give the camera file that mode, and its f_L and b_L0";
    input_->camera = other;
    trial_ = trial;
  }

  // Of several grids, the one with which lenses agree best.
  void DecideGrid(const std::vector<GridCandidate>& grids) {
    std::string tried = Format("%.0f", trial_.information);
    for (size_t i = 1; i < grids.size(); ++i) {
      const Choice choice = TryGrid(grids[i]);
      tried += Format(", %.0f", choice.trial.information);
      if (choice.trial.information > trial_.information) Choose(choice);
    }
    if (grids.size() > 1) {
      input_->grid_report += "; its depths of the first frame are the most certain of " +
                             std::to_string(grids.size()) + " grids' (information " + tried + ")";
    }
    input_->grid_report += mode_report_;
  }

  // The order of lens types 1 and 2 in grid files is not reliable: the one whose focused image has
  // more gradient energy is right.
  void DecideTypeOrder() {
    const std::vector<MicroLensType>& types = input_->camera.micro_lens_grid->types;
    if (types.size() != 3 || (types[1].min_virtual_depth == types[2].min_virtual_depth &&
                              types[1].max_virtual_depth == types[2].max_virtual_depth)) {
      return;
    }
    MicroLensGrid grid = *input_->camera.micro_lens_grid;
    std::swap(grid.types[1].offset, grid.types[2].offset);
    PlenopticCamera swapped = input_->camera;
    swapped.micro_lens_grid = grid;
    const double as_filed = trial_.gradient_energy;
    const double exchanged = Try(swapped, input_->white).gradient_energy;
    input_->grid_report += Format("; lens types 1 and 2 %s (gradient energy %.2f, exchanged %.2f)",
                                  exchanged > as_filed ? "exchanged" : "as in the file",
                                  as_filed,
                                  exchanged);
    if (exchanged > as_filed) input_->camera = swapped;
  }

  const RawFrame& first_;
  RawInput* input_;
  std::vector<cv::Mat> images_;  // the vignetting is found on
  CameraTrial trial_;
  std::string mode_report_;
};

}  // namespace

void DecideCamera(const std::string& grid_path,
                  const std::vector<RawFrame>& frames,
                  bool find_vignetting,
                  RawInput* input) {
  WithThreads(input->options.threads, [&] {
    const std::vector<GridCandidate> grids = FindGrids(grid_path, frames, *input);
    FirstFrameDecisions(frames, find_vignetting, input).Decide(grids);
  });
}

}  // namespace prism
