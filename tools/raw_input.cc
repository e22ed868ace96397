// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/raw_input.h"

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <utility>
#include <vector>

#include "prism/base/error.h"
#include "prism/io/camera_file.h"
#include "prism/lightfield/grid_estimation.h"

namespace prism {
namespace {

constexpr double kMaxRms = 0.05;      // of a micro-image centre, in pitches, on a white image
constexpr double kMinContrast = 0.1;  // below that raw frames do not show the grid

RawPixels ReadPixels(const std::string& colour) {
  if (colour == "bayer_rggb") return RawPixels::kBayerRggb;
  if (colour == "bayer_bggr") return RawPixels::kBayerBggr;
  if (colour == "bayer_grbg") return RawPixels::kBayerGrbg;
  if (colour == "bayer_gbrg") return RawPixels::kBayerGbrg;
  if (colour == "auto" || colour == "gray" || colour == "colour") return RawPixels::kGray;
  throw InputError("--colour",
                   "'" + colour + "'",
                   "auto, gray, colour, bayer_rggb, bayer_bggr, bayer_grbg or bayer_gbrg");
}

int ChannelsOf(const std::string& colour) {
  return colour == "auto" ? 0 : colour == "colour" ? 3 : 1;
}

void RefineCameraGrid(const std::string& grid_path, RawInput* input) {
  std::vector<cv::Mat> images;
  constexpr int kMaxFrames = 6;
  const int size = input->sequence->size();
  const bool has_white = !input->white.empty();
  if (has_white) {
    images.push_back(input->white);
  } else {
    for (int i = 0; i < std::min(size, kMaxFrames); ++i) {
      images.push_back(input->sequence->Read(i * size / std::min(size, kMaxFrames)).image);
    }
  }
  MicroLensGrid& grid = *input->camera.micro_lens_grid;
  const std::optional<GridFit> fit = RefineGrid(MeanImage(images), grid);
  const char* source = has_white ? "white image" : "raw frames";
  char text[256];
  if (has_white && (!fit || fit->rms_px > kMaxRms * grid.diameter_px || fit->contrast < 0.05)) {
    std::snprintf(text,
                  sizeof(text),
                  "a pitch of %.4f px and micro images %.2f px (RMS) off the white image's",
                  grid.diameter_px,
                  fit ? fit->rms_px : 0.0);
    throw InputError(grid_path, text, "the grid of the white image");
  }
  if (!fit || fit->contrast < kMinContrast || fit->rms_px > kMaxRms * grid.diameter_px) {
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

RawInput OpenRawInput(const RawInputOptions& options) {
  RawInput input;
  input.camera = ReadPlenopticCamera(options.camera);
  if (!options.micro_lens_grid.empty()) {
    input.camera.micro_lens_grid = ReadMicroLensGrid(options.micro_lens_grid);
  }
  if (!input.camera.micro_lens_grid) {
    throw InputError(options.camera,
                     "no micro-lens grid",
                     "one in the camera file or --micro_lens_grid for raw frames");
  }
  input.options.preparation.pixels = ReadPixels(options.colour);
  input.sequence.emplace(options.folder, input.camera, ChannelsOf(options.colour));
  const std::string white =
      options.white_image.empty() ? input.sequence->WhiteImagePath() : options.white_image;
  if (!white.empty()) input.white = ReadWhiteImage(white, input.camera);
  RefineCameraGrid(options.micro_lens_grid.empty() ? options.camera : options.micro_lens_grid,
                   &input);
  DecideTypeOrder(&input);
  return input;
}

}  // namespace prism
