// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/run/raw_input.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <utility>
#include <vector>

#include "prism/base/error.h"
#include "prism/io/camera_file.h"
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

std::optional<RawPixels> PixelsOf(const std::string& colour) {
  if (colour == "bayer_rggb") return RawPixels::kBayerRggb;
  if (colour == "bayer_bggr") return RawPixels::kBayerBggr;
  if (colour == "bayer_grbg") return RawPixels::kBayerGrbg;
  if (colour == "bayer_gbrg") return RawPixels::kBayerGbrg;
  if (colour == "auto" || colour == "gray" || colour == "colour") return RawPixels::kGray;
  return std::nullopt;
}

int ChannelsOf(const std::string& colour) {
  return colour == "auto" ? 0 : colour == "colour" ? 3 : 1;
}

// Frames spread over the sequence: what they show differs.
std::vector<cv::Mat> SomeRawFrames(const RawSequence& sequence) {
  constexpr int kMaxFrames = 6;
  const int count = std::min(sequence.size(), kMaxFrames);
  std::vector<cv::Mat> images;
  for (int i = 0; i < count; ++i) {
    images.push_back(sequence.Read(i * sequence.size() / count).image);
  }
  return images;
}

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

// On the white image, or on the frames where there is none.
void RefineCameraGrid(const std::string& grid_path,
                      const std::vector<cv::Mat>& frames,
                      RawInput* input) {
  const bool has_white = !input->white.empty();
  const ImageF image = MeanImage(has_white ? std::vector<cv::Mat>{input->white} : frames);
  MicroLensGrid& grid = *input->camera.micro_lens_grid;
  const std::optional<GridFit> fit =
      has_white ? RefineGrid(image, grid) : RefineGridOnFrames(image, grid);
  const char* source = has_white ? "white image" : "raw frames";
  const bool fits = fit && fit->rms_px < kMaxRms * grid.diameter_px &&
                    fit->contrast > (has_white ? kMinContrastOfWhite : kMinContrastOfFrames);
  if (!fits && has_white) ThrowGridDoesNotFit(grid_path, grid, source, EstimateGrid(image));
  char text[256];
  if (!fits) {
    std::snprintf(text,
                  sizeof(text),
                  "micro-lens grid kept as it is: the %s do not show it well enough to refine it "
                  "(contrast %.2f, RMS %.2f px)",
                  source,
                  fit ? fit->contrast : 0.0,
                  fit ? fit->rms_px : 0.0);
    input->grid_report = text;
    return;
  }
  if (std::abs(fit->grid.diameter_px / grid.diameter_px - 1) > kMaxPitchChange) {
    ThrowGridDoesNotFit(grid_path, grid, source, fit);
  }
  std::snprintf(text,
                sizeof(text),
                "micro-lens grid refined on the %s: %d micro images, RMS %.3f px, moved by at most "
                "%.3f px, pitch %.4f px, rotation %.6f rad%s",
                source,
                fit->lenses,
                fit->rms_px,
                fit->max_change_px,
                fit->grid.diameter_px,
                fit->grid.rotation,
                fit->rotation_flipped ? " (opposite sign to the file's)" : "");
  grid = fit->grid;
  input->grid_report = text;
}

// Without a white image the frames say how their micro images are shaded.
void FindVignetting(const std::vector<cv::Mat>& frames, RawInput* input) {
  std::vector<ImageF> gray;
  for (const cv::Mat& image : frames) gray.push_back(MeanImage({image}));
  std::optional<Vignetting> vignetting = EstimateVignetting(LensTable(input->camera), gray);
  char text[200];
  if (!vignetting) {
    std::snprintf(text,
                  sizeof(text),
                  "; no white image, and too few micro images to tell the vignetting from: none is "
                  "corrected");
  } else if (!vignetting->IsNeeded()) {
    std::snprintf(
        text,
        sizeof(text),
        "; no white image, and none needed: micro images are as bright at the rim (%.0f %% "
        "of their centre)",
        100 * vignetting->rim);
  } else {
    std::snprintf(text,
                  sizeof(text),
                  "; no white image: vignetting found on %d micro images (rim at %.0f %% of the "
                  "centre)",
                  vignetting->micro_images,
                  100 * vignetting->rim);
    input->white = std::move(vignetting->white);
  }
  input->grid_report += text;
}

// The order of lens types 1 and 2 in grid files is not reliable: the one whose focused image of the
// first frame has more gradient energy is right.
void DecideTypeOrder(RawInput* input) {
  const std::vector<MicroLensType>& types = input->camera.micro_lens_grid->types;
  if (types.size() != 3 || (types[1].min_virtual_depth == types[2].min_virtual_depth &&
                            types[1].max_virtual_depth == types[2].max_virtual_depth)) {
    return;
  }
  const RawFrame frame = input->sequence->Read(0);
  const MicroLensGrid filed = *input->camera.micro_lens_grid;
  MicroLensGrid swapped = filed;
  std::swap(swapped.types[1].offset, swapped.types[2].offset);
  const auto sharpness = [&](const MicroLensGrid& grid) {
    PlenopticCamera camera = input->camera;
    camera.micro_lens_grid = grid;
    LightFieldProcessor processor(camera, input->white, input->options);
    const LightFieldFrame result = processor.Process(frame);
    const ImageF energy = SquaredGradientMagnitude(result.image[0]);
    return std::accumulate(energy.data(), energy.data() + energy.size(), 0.0) /
           static_cast<double>(energy.size());
  };
  const double as_filed = sharpness(filed);
  const double exchanged = sharpness(swapped);
  char text[160];
  std::snprintf(text,
                sizeof(text),
                "; lens types 1 and 2 %s (gradient energy %.2f, exchanged %.2f)",
                exchanged > as_filed ? "exchanged" : "as in the file",
                as_filed,
                exchanged);
  input->grid_report += text;
  if (exchanged > as_filed) input->camera.micro_lens_grid = swapped;
}

}  // namespace

bool IsRawColour(const std::string& colour) { return PixelsOf(colour).has_value(); }

RawInput OpenRawInput(const RawInputOptions& options) {
  const std::optional<RawPixels> pixels = PixelsOf(options.colour);
  if (!pixels) throw OptionError("colour", "'" + options.colour + "'", kRawColours);
  if (options.threads < 0) {
    throw OptionError("threads", std::to_string(options.threads), "0 (one a core) or more");
  }
  RawInput input;
  input.camera = ReadPlenopticCamera(options.camera);
  if (!options.micro_lens_grid.empty()) {
    input.camera.micro_lens_grid = ReadMicroLensGrid(options.micro_lens_grid);
  }
  if (!input.camera.micro_lens_grid) {
    throw InputError(options.camera,
                     "no micro-lens grid",
                     "one there or in a micro_lens_grid file, for raw frames");
  }
  input.options.preparation.pixels = *pixels;
  input.options.threads = options.threads;
  input.sequence.emplace(options.folder, input.camera, ChannelsOf(options.colour));
  const std::string white =
      options.white_image.empty() ? input.sequence->WhiteImagePath() : options.white_image;
  if (!white.empty() && white != kNoWhiteImage) {
    input.white = ReadWhiteImage(white, input.camera);
  }
  const std::string grid_path =
      options.micro_lens_grid.empty() ? options.camera : options.micro_lens_grid;
  const std::vector<cv::Mat> frames =
      input.white.empty() ? SomeRawFrames(*input.sequence) : std::vector<cv::Mat>();
  WithThreads(options.threads, [&] { RefineCameraGrid(grid_path, frames, &input); });
  if (white.empty()) FindVignetting(frames, &input);
  DecideTypeOrder(&input);
  return input;
}

}  // namespace prism
