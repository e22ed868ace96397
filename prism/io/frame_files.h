// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace prism {

struct FrameFile {
  int64_t time_ns = 0;
  std::string path;      // of an image, or of the video that holds it
  int video_frame = -1;  // of that video, from 0 on; -1: an image
};

struct FrameFiles {
  std::vector<FrameFile> frames;  // at least one, times strictly increasing
  std::string source;             // where they and their times are from, for people to read
};

// The raw frames of a folder, the first of:
//   raw.txt                                   `time path` a line
//   data.csv, mav0/cam0/data.csv, cam0/...    as EuRoC: `time_ns,name`, images in data/ beside it
//   images (png, jpg, tif, bmp) in raw/, images/, frames/, data/ or the folder itself, but for
//   those whose name begins with `white`
//   one video (avi, mkv, mov, mp4) in the folder, or `folder` itself if it is one
// Times of images: `rate_hz`, if it is above 0; else those in the names (19 digits ns, 16 us,
// digits with a point s); else 10 Hz is assumed. Names are ordered as people do, 9 before 10.
// Times of a video: `rate_hz`, else its own rate.
// Throws InputError for a folder without frames, a bad list, a file of a list that is missing, a
// video that does not open (its codec is missing, say) or more than one.
// With `skip_missing` such a file is no error here.
FrameFiles FindFrameFiles(const std::string& folder, double rate_hz, bool skip_missing = false);

// True if FindFrameFiles would find images or videos there without a raw.txt.
bool HasUnlistedFrames(const std::string& folder);

// The file of a folder, or of the one a video lies in, with this name, whatever its case; empty if
// there is none.
std::string FindFile(const std::string& place, const std::string& name);

}  // namespace prism
