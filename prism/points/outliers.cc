// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/points/outliers.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "prism/base/statistics.h"
#include "prism/solver/linearize.h"

namespace prism {
namespace {

// RMS of every factor of a graph.
std::vector<double> FactorRms(const WindowGraph& graph) {
  std::vector<double> rms;
  for (const FactorGraph::Factor& factor : graph.factors()) {
    const Eigen::VectorXd r = EvaluateFactor(graph, factor).residuals;
    rms.push_back(r.size() > 0 ? r.norm() / std::sqrt(static_cast<double>(r.size())) : 0);
  }
  return rms;
}

std::vector<bool> FindOutliers(const WindowGraph& graph, const TermList& terms) {
  const std::vector<double> rms = FactorRms(graph);
  std::map<std::pair<int, int>, std::vector<double>> groups;  // by term and group
  for (size_t i = 0; i < rms.size(); ++i) {
    const FactorGraph::Factor& factor = graph.factors()[i];
    if (terms[factor.term]->outlier_rule().quantile_factor > 0) {
      groups[{factor.term, factor.group}].push_back(rms[i]);
    }
  }
  std::map<std::pair<int, int>, double> limits;
  for (const auto& [group, values] : groups) {
    const OutlierRule rule = terms[group.first]->outlier_rule();
    limits[group] = 0.5 * (rule.max_rms + rule.quantile_factor * Quantile(values, rule.quantile));
  }
  std::vector<bool> is_outlier;
  for (size_t i = 0; i < rms.size(); ++i) {
    const FactorGraph::Factor& factor = graph.factors()[i];
    const auto limit = limits.find({factor.term, factor.group});
    is_outlier.push_back(
        rms[i] >
        (limit != limits.end() ? limit->second : terms[factor.term]->outlier_rule().max_rms));
  }
  return is_outlier;
}

}  // namespace

OutlierResult RemoveOutliers(const TermList& terms,
                             const WindowGraphOptions& options,
                             Window* window) {
  OutlierResult result;
  result.factors_rejected.assign(terms.size(), 0);
  const std::unique_ptr<WindowGraph> graph = BuildWindowGraph(*window, terms, options);
  std::vector<Point*> points;
  for (const auto& keyframe : window->keyframes) {
    for (const auto& point : keyframe->points) points.push_back(point.get());
  }
  std::vector<int> ties(points.size(), 0), kept_ties(points.size(), 0);
  const std::vector<bool> is_outlier = FindOutliers(*graph, terms);
  for (size_t i = 0; i < is_outlier.size(); ++i) {
    const FactorGraph::Factor& factor = graph->factors()[i];
    const bool is_tie = graph->TiesFrame(factor);
    Point* tied = nullptr;
    for (int k = 0; k < factor.num_blocks; ++k) {
      const int number = graph->BlocksOf(factor)[k] - graph->FirstPointBlock();
      if (number < 0) continue;
      tied = points[number];
      ties[number] += is_tie;
      kept_ties[number] += is_tie && !is_outlier[i];
    }
    if (!is_outlier[i]) continue;
    ++result.factors_rejected[factor.term];
    terms[factor.term]->Reject(factor, tied, window);
  }
  size_t number = 0;
  for (const auto& keyframe : window->keyframes) {
    auto& hosted = keyframe->points;
    const auto is_useless = [&](const std::unique_ptr<Point>& point) {
      const bool is_lost = ties[number] > 0 && kept_ties[number] == 0;
      ++number;
      return is_lost || !(point->rho > 0) || !(point->rho * window->camera.f < 1);
    };
    const auto end = std::remove_if(hosted.begin(), hosted.end(), is_useless);
    result.points_dropped += static_cast<int>(hosted.end() - end);
    hosted.erase(end, hosted.end());
  }
  return result;
}

}  // namespace prism
