// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/prior_term.h"

#include <glog/logging.h>

#include "prism/factors/frame_manifold.h"
#include "prism/solver/linear_prior.h"

namespace prism {
namespace {

// LinearPriorCost that keeps the prior it is made of.
class NormalPriorCost : public LinearPriorCost {
 public:
  explicit NormalPriorCost(std::unique_ptr<const LinearPrior> prior)
      : LinearPriorCost(prior.get()), prior_(std::move(prior)) {}

 private:
  std::unique_ptr<const LinearPrior> prior_;
};

void AddStatePrior(const StateBlock& state, int owner, WindowGraph* graph) {
  if (state.prior_sigma.size() == 0) return;
  FactorGraph::NewFactor factor;
  factor.cost = std::make_unique<NormalPriorCost>(std::make_unique<LinearPrior>(
      MakeNormalPrior(state.kind, owner, state.prior_mean, state.prior_sigma)));
  const int block = graph->FindBlock(state.kind->name, owner);
  CHECK_GE(block, 0) << state.kind->name;
  graph->AddFactor(std::move(factor), {block});
}

}  // namespace

void MarginalizationPriorTerm::AddFactors(const Window& window, WindowGraph* graph) const {
  if (window.prior.empty()) return;
  std::vector<int> blocks;
  for (const LinearPrior::Block& block : window.prior.blocks) {
    blocks.push_back(graph->FindBlock(block.kind->name, block.owner));
    CHECK_GE(blocks.back(), 0) << block.kind->name << " of " << block.owner
                               << " is in the prior but not in the window";
  }
  FactorGraph::NewFactor factor;
  factor.cost = std::make_unique<LinearPriorCost>(&window.prior);
  factor.keeps_first_estimates = true;
  factor.is_linear = true;
  graph->AddFactor(std::move(factor), blocks);
}

void StatePriorTerm::AddFactors(const Window& window, WindowGraph* graph) const {
  for (const auto& keyframe : window.keyframes) {
    for (const StateBlock& state : keyframe->states) AddStatePrior(state, keyframe->id, graph);
  }
  for (const StateBlock& state : window.states) AddStatePrior(state, kRunOwner, graph);
}

void AnchorFirstKeyframe(Window* window) {
  CHECK_EQ(window->keyframes.size(), 1u);
  Keyframe& keyframe = window->newest();
  // 0.01 mm, 0.01 mrad, 0.1 % of gain and 0.1 intensities: far below what images tell.
  Eigen::VectorXd sigma(FrameState::kTangentSize);
  sigma << 1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-3, 0.1;
  window->prior =
      MakeNormalPrior(FrameStateKind(),
                      keyframe.id,
                      Eigen::Map<const Eigen::VectorXd>(keyframe.state.data(), FrameState::kSize),
                      sigma);
  keyframe.first_estimate = keyframe.state;
}

}  // namespace prism
