// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <opencv2/core/mat.hpp>

#include "prism/camera/plenoptic_camera.h"
#include "prism/io/raw_sequence.h"
#include "prism/lightfield/light_field_processor.h"

namespace prism {

// Values of RawInputOptions::colour.
inline constexpr char kRawColours[] =
    "auto, gray, colour, bayer_rggb, bayer_bggr, bayer_grbg or bayer_gbrg";
bool IsRawColour(const std::string& colour);

inline constexpr int kMaxThreads = 1024;

inline constexpr char kNoWhiteImage[] = "none";

// What a user says of a raw sequence; files and folders may be empty where that is said.
struct RawInputOptions {
  std::string folder;
  std::string camera;           // file
  std::string micro_lens_grid;  // file; empty: the camera file's own grid
  // File; empty: the folder's white.png, else what the frames tell (EstimateVignetting);
  // kNoWhiteImage: neither, the frames are taken as they are.
  std::string white_image;
  std::string colour = "auto";  // see kRawColours
  int threads = 0;              // of the processing, now and later (LightFieldOptions)
  bool focus_colour = false;    // LightFieldFrame::colour of colour and Bayer frames as well
  double rate_hz = 0;           // of frames without a list (FindFrameFiles)
  bool skip_missing = false;    // files that are missing are no error before they are read
  FocusedImage focused_image = FocusedImage::kVirtualPoints;  // that frames are turned into
};

// By its name; throws OptionError for another one.
FocusedImage FocusedImageOf(const std::string& name);

// Frames of a sequence that are looked at where a camera's files leave something open.
inline constexpr int kFramesToLookAt = 6;

// The options of the processing; OptionError for an unknown colour or a negative number of threads.
LightFieldOptions LightFieldOptionsOf(const RawInputOptions& options);

// A raw sequence with all that its processing needs.
struct RawInput {
  PlenopticCamera camera;  // with its micro-lens grid, refined
  cv::Mat white;           // given or found on the frames; empty: micro images are not shaded
  std::optional<RawSequence> sequence;
  LightFieldOptions options;  // with the colour pattern of the sequence and the threads
  std::string grid_report;    // what was found about grid and vignetting, one line
};

// Opens a raw sequence. A grid is refined on the white image, or on some frames where there is
// none, which then also tell the vignetting. What is still open is decided by the first frame: the
// sign of the grid's rotation where it could not be refined, the mode where lenses hardly agree in
// the camera's, and the order of lens types by sharpness. `auto` takes images of one channel as
// gray and others as colour; a Bayer mosaic that is not declared as one, or with green on the other
// diagonal, is an error (a warning for `gray`). Throws InputError, also for a grid whose pitch does
// not fit the white image, and OptionError as LightFieldOptionsOf.
RawInput OpenRawInput(const RawInputOptions& options);

}  // namespace prism
