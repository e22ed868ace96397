// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "prism/base/stage_timer.h"
#include "prism/camera/plenoptic_camera.h"
#include "prism/io/rgbd_to_plenoptic.h"
#include "prism/scene/frame.h"

namespace prism {

// What a folder in TUM RGB-D layout does not say, or not in our way.
struct RgbdLayoutOptions {
  // fx fy cx cy [k1 k2 p1 p2 [k3]] in px, distortion as OpenCV's; empty: calibration.txt.
  std::vector<double> pinhole;
  double depth_factor = 5000;  // values of depth images a metre
};

// The figures of `fx,fy,cx,cy[,k1,k2,p1,p2[,k3]]`, or of a camera of the TUM benchmark by its name:
// freiburg1, freiburg2, freiburg3, or ros_default (of all of them, what its authors suggest).
// Throws OptionError.
std::vector<double> ParsePinhole(const std::string& text);

// A folder in TUM RGB-D layout: `associations.txt` (time rgb time depth a line) or `rgb.txt` and
// `depth.txt` (time path a line, matched by time within 20 ms; what has no partner is left out),
// 16-bit depth PNGs in 1/5000 m with 0 = none, and `calibration.txt` (fx fy cx cy width height) or
// RgbdLayoutOptions::pinhole. Where pixels are not square, or there is distortion, images and depth
// are resampled to what a camera without them sees. Frames are turned into plenoptic ones.
//
// Throws InputError: missing or empty folder or list, times that do not increase, lists of which
// half have no partner, an associated pair 100 ms apart, a missing file (with `skip_missing` only
// when it is read); on Read an image that is missing, does not decode or has another size, or depth
// of 65535 everywhere.
class RgbdSequence {
 public:
  // `lens` gives f_L, b_L0 and B of the plenoptic camera to stand in for.
  RgbdSequence(const std::string& folder,
               const PlenopticCamera& lens,
               const RgbdConversionOptions& options,
               const RgbdLayoutOptions& layout = {},
               bool skip_missing = false);

  int size() const { return static_cast<int>(entries_.size()); }
  const PlenopticCamera& camera() const { return camera_; }
  int64_t time_ns(int index) const { return entries_[index].time_ns; }
  // The files of a frame, within the folder.
  const std::string& image_path(int index) const { return entries_[index].image_path; }
  const std::string& depth_path(int index) const { return entries_[index].depth_path; }
  // What the lists leave out, a line each: images without a partner.
  const std::vector<std::string>& notes() const { return notes_; }

  // Deterministic in the index and the seed; safe to call from several threads with a timer each,
  // which gets the stages "read image" and "convert frame" (null: none).
  LightFieldFrame Read(int index, StageTimer* timer = nullptr) const;

 private:
  struct Entry {
    int64_t time_ns;
    std::string image_path;
    std::string depth_path;
  };
  struct Images {
    cv::Mat gray;
    cv::Mat depth;  // as stored
  };

  void ReadEntries(bool skip_missing);
  PinholeCamera ReadCamera(const RgbdLayoutOptions& layout);
  void ReadAssociations();
  void AssociateLists();  // of rgb.txt and depth.txt
  Images ReadImages(const Entry& entry) const;

  std::string folder_;
  double depth_factor_;
  cv::Mat map_x_, map_y_;  // where pixels come from; empty: images are taken as they are
  PlenopticCamera camera_;
  RgbdConversionOptions options_;
  std::vector<Entry> entries_;
  std::vector<std::string> notes_;
};

// True if the folder looks like such a sequence.
bool IsRgbdSequence(const std::string& folder);

}  // namespace prism
