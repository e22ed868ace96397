// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/verify/term_check.h"

#include <algorithm>
#include <map>
#include <random>
#include <utility>

#include "prism/base/random.h"
#include "prism/factors/frame_manifold.h"
#include "prism/solver/linearize.h"
#include "prism/verify/numeric.h"

namespace prism {
namespace {

constexpr int kKeyframes = 3;
constexpr int kPointsPerKeyframe = 4;

// Bilinear in x and y, so that the interpolant is the function itself and has no kinks; exact in
// float.
std::shared_ptr<const LightFieldFrame> AnalyticFrame(int width, int height, int64_t time_ns) {
  auto frame = std::make_shared<LightFieldFrame>();
  frame->inverse_virtual_depth = ImageF(width, height, 0.4f);
  frame->sigma = ImageF(width, height, 0.004f);
  frame->time_ns = time_ns;
  ImageF image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image(x, y) = 60 + 0.125f * static_cast<float>(x) + 0.0625f * static_cast<float>(y) -
                    static_cast<float>(x * y) / 16384.0f;
    }
  }
  frame->image.push_back(std::move(image));
  return frame;
}

Eigen::VectorXd RandomVector(Eigen::Index size, double sigma, std::mt19937_64* generator) {
  std::normal_distribution<double> normal;
  Eigen::VectorXd vector(size);
  for (Eigen::Index i = 0; i < size; ++i) vector(i) = sigma * normal(*generator);
  return vector;
}

// Moves the values of a block by an increment of its tangent space.
void Move(const BlockKind& kind, const Eigen::VectorXd& delta, double* values) {
  if (!kind.manifold) {
    Eigen::Map<Eigen::VectorXd>(values, kind.size) += delta;
    return;
  }
  const std::vector<double> before(values, values + kind.size);
  kind.manifold->Plus(before.data(), delta.data(), values);
}

Window RandomWindow(const PlenopticProjection& camera,
                    const TermList& terms,
                    std::mt19937_64* generator) {
  std::uniform_real_distribution<double> uniform(0, 1);
  Window window(camera);
  const SE3 first = SE3::Exp(RandomVector(6, 1, generator));
  for (int i = 0; i < kKeyframes; ++i) {
    auto keyframe = std::make_unique<Keyframe>();
    keyframe->id = i;
    constexpr int64_t kInterval_ns = 100'000'000;
    keyframe->frame = AnalyticFrame(camera.width, camera.height, i * kInterval_ns);
    const Vector6d motion = RandomVector(6, 0.02, generator);
    const Eigen::VectorXd brightness = RandomVector(2, 0.1, generator);
    keyframe->state = FrameState(SE3::Exp(motion) * first, brightness(0), 10 * brightness(1));
    for (int p = 0; p < kPointsPerKeyframe; ++p) {
      auto point = std::make_unique<Point>();
      const Eigen::Vector2d px(camera.width * (0.2 + 0.6 * uniform(*generator)),
                               camera.height * (0.2 + 0.6 * uniform(*generator)));
      MakePatch(keyframe->frame->image[0], px, &point->patch);
      point->rho = 0.1 + uniform(*generator);
      point->w_measured = InverseVirtualDepth(camera, point->rho) + 0.003;
      point->w_sigma = 0.004;
      keyframe->points.push_back(std::move(point));
    }
    window.keyframes.push_back(std::move(keyframe));
    for (const auto& term : terms) term->AddStates(&window);
  }
  // States and prior away from where they were: a Jacobian at 0 may be right by chance.
  for (const auto& keyframe : window.keyframes) {
    for (StateBlock& state : keyframe->states) {
      Move(*state.kind,
           RandomVector(state.kind->TangentSize(), 0.01, generator),
           state.value.data());
    }
  }
  for (StateBlock& state : window.states) {
    Move(*state.kind, RandomVector(state.kind->TangentSize(), 0.01, generator), state.value.data());
  }
  window.prior.A = Eigen::MatrixXd(10, 2 * FrameState::kTangentSize);
  for (Eigen::Index i = 0; i < window.prior.A.cols(); ++i) {
    window.prior.A.col(i) = RandomVector(10, 1, generator);
  }
  window.prior.b = RandomVector(10, 1, generator);
  for (int i = 0; i < 2; ++i) {
    window.prior.blocks.push_back(
        {FrameStateKind(),
         i,
         Eigen::Map<const Eigen::VectorXd>(window.keyframes[i]->state.data(), FrameState::kSize)});
  }
  return window;
}

Eigen::VectorXd ResidualsAt(const FactorGraph::Factor& factor,
                            int block,
                            const Eigen::VectorXd& delta,
                            WindowGraph* graph) {
  const BlockKind& kind = *graph->blocks()[block].kind;
  double* values = graph->values(block);
  const std::vector<double> before(values, values + kind.size);
  Move(kind, delta, values);
  graph->PrepareForEvaluation();
  Eigen::VectorXd residuals = EvaluateFactor(*graph, factor).residuals;
  std::copy(before.begin(), before.end(), values);
  return residuals;
}

}  // namespace

std::vector<JacobianBlockCheck> CheckTerms(const PlenopticCamera& model,
                                           const TermList& terms,
                                           const JacobianCheckOptions& options) {
  const PlenopticProjection camera(model);
  std::mt19937_64 generator = SeededGenerator(options.seed, 1);
  // By term, and by position and kind of the block.
  std::map<std::pair<int, std::string>, JacobianBlockCheck> checks;
  const int windows = std::max(1, options.samples / 50);
  for (int i = 0; i < windows; ++i) {
    const Window window = RandomWindow(camera, terms, &generator);
    const std::unique_ptr<WindowGraph> graph = BuildWindowGraph(window, terms, {});
    for (const FactorGraph::Factor& factor : graph->factors()) {
      graph->PrepareForEvaluation();
      const LinearizedFactor linearized = LinearizeFactor(*graph, factor);
      for (int k = 0; k < factor.num_blocks; ++k) {
        const int block = graph->BlocksOf(factor)[k];
        const BlockKind& kind = *graph->blocks()[block].kind;
        const std::string name = kind.name + " (block " + std::to_string(k + 1) + ")";
        JacobianBlockCheck& check = checks[{factor.term, name}];
        check.residual = terms[factor.term]->name();
        check.block = name;
        const Eigen::MatrixXd numeric = NumericTangentJacobian(
            [&](const Eigen::VectorXd& delta) {
              return ResidualsAt(factor, block, delta, graph.get());
            },
            kind.TangentSize());
        // Differences of large residuals are rounded accordingly.
        const double scale = 1 / std::max(1.0, linearized.value.residuals.cwiseAbs().maxCoeff());
        RaiseMixedError(scale * linearized.jacobians[k], scale * numeric, &check.numeric_error);
        check.largest_element =
            std::max(check.largest_element, linearized.jacobians[k].cwiseAbs().maxCoeff());
      }
    }
  }
  std::vector<JacobianBlockCheck> result;
  for (auto& [key, check] : checks) result.push_back(std::move(check));
  return result;
}

}  // namespace prism
