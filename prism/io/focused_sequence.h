// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "prism/camera/plenoptic_camera.h"
#include "prism/scene/frame.h"

namespace prism {

// A folder of processed frames: `focused.txt`, a line `time image inverse_virtual_depth [sigma]`
// each; the image 8-bit gray on the focused grid, the other two 16-bit PNGs,
// 1/v = 1 - value / 65535 and sigma = value / 65535 * 0.1, 0 = no measurement.
//
// Throws InputError: no such folder or list, an empty list, times that do not increase, a file that
// is missing (with `skip_missing` only when it is read); on Read an image that does not decode or
// is of another size than the camera's focused image, and 1/v outside (0, 0.5].
class FocusedSequence {
 public:
  // Measurements without a sigma file get `default_sigma`.
  FocusedSequence(const std::string& folder,
                  const PlenopticCamera& camera,
                  bool skip_missing = false,
                  double default_sigma = 0.004);

  int size() const { return static_cast<int>(entries_.size()); }
  int64_t time_ns(int index) const { return entries_[index].time_ns; }

  // Safe to call from several threads. Precondition: 0 <= index < size().
  LightFieldFrame Read(int index) const;

 private:
  struct Entry {
    int64_t time_ns;
    std::string image_path;
    std::string depth_path;
    std::string sigma_path;  // empty: none
  };
  int width_, height_;
  double default_sigma_;
  std::vector<Entry> entries_;
};

// Writes such a folder frame by frame: focused/, inverse_virtual_depth/, sigma/ and, with Finish,
// focused.txt. Throws InputError if a file cannot be written.
class FocusedSequenceWriter {
 public:
  explicit FocusedSequenceWriter(const std::string& folder);
  void Write(const LightFieldFrame& frame);
  void Finish();

 private:
  std::string folder_;
  int count_ = 0;
  std::string list_;
};

// An inverse virtual depth PNG (Raytrix encoding), 0 = none. Errors as above.
ImageF ReadInverseVirtualDepth(const std::string& path, int width, int height);

// Name of the image of a frame by its number, "000012.png".
std::string FrameFileName(int frame);

// Decimal seconds with nanoseconds, as in list files.
std::string FormatTime(int64_t time_ns);

// True if the folder looks like such a sequence.
bool IsFocusedSequence(const std::string& folder);

}  // namespace prism
