// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/window_graph.h"

#include <algorithm>

#include "prism/factors/frame_manifold.h"
#include "prism/factors/term.h"

namespace prism {
namespace {

// The states of the keyframes and of the run, in the order of their blocks.
template <typename WindowType, typename Visit>
void ForEachState(WindowType& window, const Visit& visit) {
  for (auto& keyframe : window.keyframes) {
    for (auto& state : keyframe->states) visit(state, keyframe->id);
  }
  for (auto& state : window.states) visit(state, kRunOwner);
}

}  // namespace

WindowGraph::WindowGraph(const Window& window, const WindowGraphOptions& options) {
  AddFrameAndStateBlocks(window, options);
  int number = 0;
  for (const auto& keyframe : window.keyframes) {
    for (const auto& point : keyframe->points) AddBlock(InverseDepthKind(), number++, &point->rho);
  }
  MakePairs(window, options);
}

WindowGraph::WindowGraph(const Window& window, double rho, const WindowGraphOptions& options) {
  AddFrameAndStateBlocks(window, options);
  for (int block = 0; block < first_point_block_; ++block) SetConstant(block);
  AddBlock(InverseDepthKind(), 0, &rho);
  MakePairs(window, options);
}

void WindowGraph::AddFrameAndStateBlocks(const Window& window, const WindowGraphOptions& options) {
  const auto first_estimate = [&](const auto& estimate) -> const double* {
    return options.first_estimates && estimate ? estimate->data() : nullptr;
  };
  num_frames_ = static_cast<int>(window.keyframes.size());
  for (const auto& keyframe : window.keyframes) {
    AddBlock(FrameStateKind(!options.affine_brightness),
             keyframe->id,
             keyframe->state.data(),
             first_estimate(keyframe->first_estimate));
  }
  ForEachState(window, [&](const StateBlock& state, int owner) {
    AddBlock(state.kind, owner, state.value.data(), first_estimate(state.first_estimate));
  });
  first_point_block_ = static_cast<int>(blocks().size());
}

void WindowGraph::MakePairs(const Window& window, const WindowGraphOptions& options) {
  std::vector<const double*> states;
  std::vector<const FrameState*> first_estimates;
  for (size_t i = 0; i < window.keyframes.size(); ++i) {
    const auto& estimate = window.keyframes[i]->first_estimate;
    states.push_back(values(FrameBlock(i)));
    first_estimates.push_back(options.first_estimates && estimate ? &*estimate : nullptr);
  }
  pairs_ = std::make_shared<PairTable>(
      std::move(states), std::move(first_estimates), window.noise.ResidualSigma());
  AddCallback(pairs_);
}

int WindowGraph::FindBlock(const std::string& kind, int owner) const {
  for (int i = 0; i < first_point_block_; ++i) {
    if (blocks()[i].owner == owner && blocks()[i].kind->name == kind) return i;
  }
  return -1;
}

bool WindowGraph::TiesFrame(const Factor& factor) const {
  return std::any_of(BlocksOf(factor), BlocksOf(factor) + factor.num_blocks, [&](int block) {
    return block < num_frames_;
  });
}

void WindowGraph::CopyTo(Window* window) const {
  int block = 0;
  for (const auto& keyframe : window->keyframes) keyframe->state = FrameState(values(block++));
  ForEachState(*window, [&](StateBlock& state, int /*owner*/) {
    std::copy_n(values(block++), state.value.size(), state.value.data());
  });
  for (const auto& keyframe : window->keyframes) {
    for (const auto& point : keyframe->points) point->rho = *values(block++);
  }
}

void WindowGraph::KeepFirstEstimates(const std::vector<int>& kept, Window* window) const {
  std::vector<bool> is_kept(blocks().size(), false);
  for (const int block : kept) is_kept[block] = true;
  int block = 0;
  for (const auto& keyframe : window->keyframes) {
    if (is_kept[block++] && !keyframe->first_estimate) keyframe->first_estimate = keyframe->state;
  }
  ForEachState(*window, [&](StateBlock& state, int /*owner*/) {
    if (is_kept[block++] && !state.first_estimate) state.first_estimate = state.value;
  });
}

std::unique_ptr<WindowGraph> BuildWindowGraph(const Window& window,
                                              const TermList& terms,
                                              const WindowGraphOptions& options) {
  auto graph = std::make_unique<WindowGraph>(window, options);
  int rho_block = graph->FirstPointBlock();
  for (size_t i = 0; i < window.keyframes.size(); ++i) {
    for (const auto& point : window.keyframes[i]->points) {
      for (size_t term = 0; term < terms.size(); ++term) {
        graph->BeginTerm(static_cast<int>(term));
        terms[term]->AddPointFactors(window, i, *point, rho_block, graph.get());
      }
      ++rho_block;
    }
  }
  for (size_t term = 0; term < terms.size(); ++term) {
    graph->BeginTerm(static_cast<int>(term));
    terms[term]->AddFactors(window, graph.get());
  }
  return graph;
}

}  // namespace prism
