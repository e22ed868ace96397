// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <deque>
#include <memory>
#include <vector>

#include "prism/camera/projection.h"
#include "prism/scene/keyframe.h"
#include "prism/scene/noise_model.h"
#include "prism/solver/linear_prior.h"

namespace prism {

// The state of the sliding window: keyframes (oldest first) with their points, states of the run,
// and the marginalisation prior over some of them.
struct Window {
  explicit Window(const PlenopticProjection& camera) : camera(camera) {}

  PlenopticProjection camera;  // level 0
  NoiseModel noise;
  std::deque<std::unique_ptr<Keyframe>> keyframes;
  std::vector<StateBlock> states;  // that live as long as the run
  LinearPrior prior;
  int next_point_id = 0;

  bool empty() const { return keyframes.empty(); }
  Keyframe& newest() { return *keyframes.back(); }
  const Keyframe& newest() const { return *keyframes.back(); }
  // Precondition: the window holds a keyframe of that id.
  const Keyframe& Get(int id) const {
    const auto has_id = [&](const auto& keyframe) { return keyframe->id == id; };
    return **std::find_if(keyframes.begin(), keyframes.end(), has_id);
  }
  int NumPoints() const {
    int count = 0;
    for (const auto& keyframe : keyframes) count += static_cast<int>(keyframe->points.size());
    return count;
  }
};

}  // namespace prism
