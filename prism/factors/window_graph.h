// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "prism/factors/pair_table.h"
#include "prism/scene/window.h"
#include "prism/solver/factor_graph.h"

namespace prism {

struct WindowGraphOptions {
  bool first_estimates = true;  // Jacobians of frames in the prior are evaluated at them (ablation)
  bool affine_brightness = true;  // false: brightness is held (ablation)
};

// The factor graph of a window: the blocks of its keyframes, their states, the states of the run
// and the points' inverse depths; and what factors share, the relative geometry of keyframes.
// The window must outlive the graph and keep its keyframes and points.
class WindowGraph : public FactorGraph {
 public:
  // Blocks only; terms add the factors.
  WindowGraph(const Window& window, const WindowGraphOptions& options);
  // Of all keyframes, held, and one inverse depth `rho`: for a point that may not be in the window.
  WindowGraph(const Window& window, double rho, const WindowGraphOptions& options);

  // By position in window.keyframes.
  int FrameBlock(size_t keyframe_index) const { return static_cast<int>(keyframe_index); }
  const FramePair& pair(size_t host_index, size_t target_index) const {
    return pairs_->pair(host_index, target_index);
  }
  // The block of a kind (by name) that belongs to `owner`; -1: there is none.
  int FindBlock(const std::string& kind, int owner = kRunOwner) const;

  // Whether a factor ties the state of a frame: an observation, not a measurement of a point by
  // itself (which may have an offset of its keyframe in it).
  bool TiesFrame(const Factor& factor) const;

  // Inverse depths are the blocks from here on, in the order of keyframes and their points.
  int FirstPointBlock() const { return first_point_block_; }
  // Writes all values back into the window.
  void CopyTo(Window* window) const;

  // Frames and states of blocks that have entered the prior keep their first estimates: the values
  // of the window, which must be those of the graph.
  void KeepFirstEstimates(const std::vector<int>& blocks, Window* window) const;

 private:
  void AddFrameAndStateBlocks(const Window& window, const WindowGraphOptions& options);
  void MakePairs(const Window& window, const WindowGraphOptions& options);

  std::shared_ptr<PairTable> pairs_;
  int num_frames_ = 0;
  int first_point_block_ = 0;
};

}  // namespace prism
