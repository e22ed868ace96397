// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/run/raw_input.h"

#include <vector>

#include <glog/logging.h>

#include "prism/base/error.h"
#include "prism/io/camera_file.h"
#include "prism/lightfield/colour_mosaic.h"
#include "prism/run/camera_decisions.h"

namespace prism {
namespace {

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

// Bayer patterns with green where the frame has it; gray for none.
std::string ColoursOf(Mosaic mosaic) {
  switch (mosaic) {
    case Mosaic::kNone:
      return "gray";
    case Mosaic::kGreenOnMainDiagonal:
      return "bayer_grbg or bayer_gbrg";
    case Mosaic::kGreenOnOtherDiagonal:
      return "bayer_rggb or bayer_bggr";
    case Mosaic::kGreenOnUnknownDiagonal:
      return "one of bayer_rggb, bayer_bggr, bayer_grbg, bayer_gbrg";
  }
  return "";
}

// A mosaic read as gray, or in another pattern, is garbage to whoever compares pixels. `gray` and
// the patterns are taken at their word where the frame does not contradict.
void RequireItsColour(const RawFrame& frame, const RawInputOptions& options) {
  if (frame.image.channels() != 1) return;
  const Mosaic mosaic = FindMosaic(frame.image);
  const std::string colours = ColoursOf(mosaic);
  const bool is_declared = colours.find(options.colour) != std::string::npos;
  if (mosaic == Mosaic::kNone || is_declared) return;
  if (options.colour == "gray") {
    LOG(WARNING) << frame.path << " looks like a colour mosaic (" << colours << "), read as gray";
    return;
  }
  throw InputError(frame.path,
                   "a colour mosaic in an image of one channel",
                   "--colour=" + colours + ", or gray");
}

}  // namespace

bool IsRawColour(const std::string& colour) { return PixelsOf(colour).has_value(); }

FocusedImage FocusedImageOf(const std::string& name) {
  FocusedImage image;
  if (!ParseFocusedImage(name, &image)) {
    throw OptionError("focused_image", "'" + name + "'", kFocusedImages);
  }
  return image;
}

LightFieldOptions LightFieldOptionsOf(const RawInputOptions& options) {
  const std::optional<RawPixels> pixels = PixelsOf(options.colour);
  if (!pixels) throw OptionError("colour", "'" + options.colour + "'", kRawColours);
  if (options.threads < 0 || options.threads > kMaxThreads) {
    throw OptionError("threads",
                      std::to_string(options.threads),
                      "0 (one a core) to " + std::to_string(kMaxThreads));
  }
  LightFieldOptions light_field;
  light_field.preparation.pixels = *pixels;
  light_field.threads = options.threads;
  light_field.focus_colour = options.focus_colour;
  return light_field;
}

RawInput OpenRawInput(const RawInputOptions& options) {
  RawInput input;
  input.options = LightFieldOptionsOf(options);
  input.camera = ReadPlenopticCamera(options.camera);
  input.camera.focused_image = options.focused_image;
  if (!options.micro_lens_grid.empty()) {
    AddMicroLensGrid(options.micro_lens_grid, &input.camera);
  }
  if (!input.camera.micro_lens_grid) {
    throw InputError(options.camera,
                     "no micro-lens grid",
                     "one there, in MLA_Calibration.xml beside the frames or in a micro_lens_grid "
                     "file, for raw frames (prism_lightfield --estimate_grid finds it)");
  }
  input.sequence.emplace(options.folder,
                         input.camera,
                         ChannelsOf(options.colour),
                         options.rate_hz,
                         options.skip_missing);
  const std::string white =
      options.white_image.empty() ? input.sequence->WhiteImagePath() : options.white_image;
  const bool has_white = !white.empty() && white != kNoWhiteImage;
  const std::vector<RawFrame> frames = input.sequence->ReadSome(has_white ? 1 : kFramesToLookAt);
  input.sequence->set_type(frames.front().image.type());
  RequireItsColour(frames.front(), options);
  if (has_white) input.white = ReadWhiteImage(white, input.camera);
  const std::string grid_path =
      options.micro_lens_grid.empty() ? options.camera : options.micro_lens_grid;
  DecideCamera(grid_path, frames, white.empty(), &input);
  return input;
}

}  // namespace prism
