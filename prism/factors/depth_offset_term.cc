// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/factors/depth_offset_term.h"

#include <glog/logging.h>

namespace prism {
namespace {

constexpr char kOffset[] = "depth offset";
constexpr char kPersistent[] = "persistent depth offset";

BlockKindPtr MakeKind(const char* name) {
  return std::make_shared<const BlockKind>(BlockKind{name, 1, BlockLifetime::kKeyframe});
}

StateBlock MakeState(const BlockKindPtr& kind, double value) {
  return {kind, Eigen::VectorXd::Constant(1, value), {}, {}};
}

const StateBlock* FindState(const Keyframe& keyframe, const char* name) {
  for (const StateBlock& state : keyframe.states) {
    if (state.kind->name == name) return &state;
  }
  return nullptr;
}

void AddDifference(const std::vector<int>& blocks, double sigma, WindowGraph* graph) {
  FactorGraph::NewFactor factor;
  factor.cost = std::make_unique<OffsetDifferenceCost>(static_cast<int>(blocks.size()), sigma);
  factor.keeps_first_estimates = true;  // its Jacobian is the same everywhere
  graph->AddFactor(std::move(factor), blocks);
}

}  // namespace

bool DepthOffsetTermOptions::IsValid(std::string* error) const {
  if (prior_sigma >= 0 && step_sigma > 0) return true;
  *error =
      "offsets of measured depths need a prior's standard deviation of 0 or more and a positive "
      "step";
  return false;
}

int DepthOffsetBlock(const WindowGraph& graph, const Keyframe& keyframe) {
  const int block = graph.FindBlock(kOffset, keyframe.id);
  return block >= 0 ? block : PersistentDepthOffsetBlock(graph, keyframe);
}

int PersistentDepthOffsetBlock(const WindowGraph& graph, const Keyframe& keyframe) {
  return graph.FindBlock(kPersistent, keyframe.id);
}

double DepthOffset(const Keyframe& keyframe) {
  const StateBlock* state = FindState(keyframe, kOffset);
  if (state == nullptr) state = FindState(keyframe, kPersistent);
  return state != nullptr ? state->value(0) : 0;
}

double PersistentDepthOffset(const Keyframe& keyframe) {
  const StateBlock* state = FindState(keyframe, kPersistent);
  return state != nullptr ? state->value(0) : DepthOffset(keyframe);
}

DepthOffsetTerm::DepthOffsetTerm(const DepthOffsetTermOptions& options) : options_(options) {
  std::string error;
  CHECK(options.IsValid(&error)) << error;
}

void DepthOffsetTerm::AddStates(Window* window) const {
  static const BlockKindPtr offset = MakeKind(kOffset), persistent = MakeKind(kPersistent);
  const auto& keyframes = window->keyframes;
  const double expected = keyframes.size() > 1 && options_.has_persistent()
                              ? PersistentDepthOffset(*keyframes[keyframes.size() - 2])
                              : 0;
  auto& states = window->newest().states;
  if (options_.per_keyframe) states.push_back(MakeState(offset, expected));
  if (!options_.has_persistent()) return;
  states.push_back(MakeState(persistent, expected));
  if (keyframes.size() == 1) {
    states.back().prior_mean = Eigen::VectorXd::Zero(1);
    states.back().prior_sigma = Eigen::VectorXd::Constant(1, options_.prior_sigma);
  }
}

void DepthOffsetTerm::AddFactors(const Window& window, WindowGraph* graph) const {
  const Keyframe* before = nullptr;
  for (const auto& keyframe : window.keyframes) {
    if (DepthOffsetBlock(*graph, *keyframe) < 0) continue;  // it came without AddStates
    // Where keyframes between have left, the prior ties what is left of the walk.
    if (options_.has_persistent() && before != nullptr && before->id + 1 == keyframe->id) {
      AddDifference({PersistentDepthOffsetBlock(*graph, *before),
                     PersistentDepthOffsetBlock(*graph, *keyframe)},
                    options_.step_sigma,
                    graph);
    }
    if (options_.per_keyframe) {
      std::vector<int> blocks = {DepthOffsetBlock(*graph, *keyframe)};
      if (options_.has_persistent()) {
        blocks.insert(blocks.begin(), PersistentDepthOffsetBlock(*graph, *keyframe));
      }
      AddDifference(blocks, window.noise.DepthOffsetSigma(), graph);
    }
    before = keyframe.get();
  }
}

OffsetDifferenceCost::OffsetDifferenceCost(int num_blocks, double sigma)
    : inverse_sigma_(1 / sigma) {
  CHECK_GT(sigma, 0);
  set_num_residuals(1);
  mutable_parameter_block_sizes()->assign(num_blocks, 1);
}

bool OffsetDifferenceCost::Evaluate(double const* const* parameters,
                                    double* residuals,
                                    double** jacobians) const {
  const size_t last = parameter_block_sizes().size() - 1;
  const double from = last > 0 ? parameters[0][0] : 0;
  residuals[0] = (parameters[last][0] - from) * inverse_sigma_;
  if (jacobians == nullptr) return true;
  if (jacobians[last] != nullptr) jacobians[last][0] = inverse_sigma_;
  if (last > 0 && jacobians[0] != nullptr) jacobians[0][0] = -inverse_sigma_;
  return true;
}

}  // namespace prism
