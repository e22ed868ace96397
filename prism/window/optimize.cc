// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/window/optimize.h"

#include <cmath>

#include "prism/solver/linearize.h"

namespace prism {

double OptimizationResult::VarianceFactor(const std::string& term) const {
  for (const TermSummary& summary : terms) {
    if (summary.name == term) return summary.variance_factor;
  }
  return 0;
}

OptimizationResult OptimizeWindow(const WindowOptions& options,
                                  const TermList& terms,
                                  Window* window) {
  const std::unique_ptr<WindowGraph> graph = BuildWindowGraph(*window, terms, options.graph);
  if (window->prior.empty()) graph->SetConstant(graph->FrameBlock(0));
  OptimizationResult result;
  result.solve = Solve(options.solve, graph.get());
  const GraphFit fit = EvaluateFit(*graph, static_cast<int>(terms.size()));
  if (result.solve.usable) {
    graph->CopyTo(window);
    int block = graph->FirstPointBlock();
    for (const auto& keyframe : window->keyframes) {
      for (const auto& point : keyframe->points) {
        const double known = fit.information[block++];
        point->rho_sigma = known > 0 ? 1 / std::sqrt(known) : 0;
      }
    }
    result.uncertainty = EvaluateUncertainty(*window, *graph);
  }
  for (size_t i = 0; i < terms.size(); ++i) {
    result.terms.push_back({terms[i]->name(), fit.terms[i].factors, fit.terms[i].variance_factor});
  }
  return result;
}

}  // namespace prism
