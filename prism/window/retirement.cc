// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/window/retirement.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glog/logging.h>
#include <opencv2/core.hpp>

#include "prism/factors/visibility.h"
#include "prism/solver/marginalize_blocks.h"

namespace prism {
namespace {

double VisibleFraction(const Window& window, const Keyframe& keyframe) {
  if (keyframe.points.empty()) return 0;
  int visible = 0;
  for (const auto& point : keyframe.points) {
    visible += IsObserved(window, keyframe, *point, window.newest());
  }
  return static_cast<double>(visible) / static_cast<double>(keyframe.points.size());
}

double Distance(const Keyframe& a, const Keyframe& b) {
  return (a.state.pose() * b.state.pose().Inverse()).translation().norm();
}

// DSO's score: sqrt(d(i, newest)) * sum over j of 1 / (d(i, j) + eps).
double DistanceScore(const Window& window, size_t i) {
  double inverse_sum = 0;
  for (size_t j = 0; j + 1 < window.keyframes.size(); ++j) {
    if (i == j) continue;
    inverse_sum += 1 / (Distance(*window.keyframes[i], *window.keyframes[j]) + 1e-5);
  }
  return std::sqrt(Distance(*window.keyframes[i], window.newest())) * inverse_sum;
}

bool IsSeenByNewestTwo(const Window& window, const Keyframe& host, const Point& point) {
  const size_t size = window.keyframes.size();
  for (size_t j = size < 2 ? 0 : size - 2; j < size; ++j) {
    const Keyframe& target = *window.keyframes[j];
    if (target.id == host.id || IsObserved(window, host, point, target)) return true;
  }
  return false;
}

// True if a factor ties the point to a keyframe.
std::vector<bool> TiedPoints(const WindowGraph& graph) {
  std::vector<bool> is_tied(graph.blocks().size() - graph.FirstPointBlock(), false);
  for (const FactorGraph::Factor& factor : graph.factors()) {
    if (!graph.TiesFrame(factor)) continue;
    for (int k = 0; k < factor.num_blocks; ++k) {
      const int point = graph.BlocksOf(factor)[k] - graph.FirstPointBlock();
      if (point >= 0) is_tied[point] = true;
    }
  }
  return is_tied;
}

}  // namespace

bool RetirementOptions::IsValid(std::string* error) const {
  if (min_visible_fraction >= 0 && min_visible_fraction < 1 && max_log_gain > 0) return true;
  *error = "retirement needs a visible fraction in [0, 1) and a positive limit of brightness";
  return false;
}

std::vector<int> KeyframesToRetire(const WindowOptions& window_options,
                                   const RetirementOptions& options,
                                   const Window& window) {
  std::vector<int> ids;
  const size_t size = window.keyframes.size();
  for (size_t i = 0; i + 2 < size; ++i) {
    const Keyframe& keyframe = *window.keyframes[i];
    const double log_gain = std::abs(keyframe.state.a() - window.newest().state.a());
    if (size - ids.size() > 3 &&
        (VisibleFraction(window, keyframe) < options.min_visible_fraction ||
         log_gain > options.max_log_gain)) {
      ids.push_back(keyframe.id);
    }
  }
  while (static_cast<int>(size - ids.size()) >= window_options.max_keyframes) {
    double best = -1;
    int best_id = -1;
    for (size_t i = 0; i + 2 < size; ++i) {
      const int id = window.keyframes[i]->id;
      if (std::find(ids.begin(), ids.end(), id) != ids.end()) continue;
      const double score = DistanceScore(window, i);
      if (score > best) {
        best = score;
        best_id = id;
      }
    }
    ids.push_back(best_id);
  }
  return ids;
}

RetirementResult RetireKeyframe(const WindowOptions& options,
                                const TermList& terms,
                                int keyframe_id,
                                Window* window) {
  RetirementResult result;
  auto& keyframes = window->keyframes;
  const auto leaving = std::find_if(keyframes.begin(), keyframes.end(), [&](const auto& keyframe) {
    return keyframe->id == keyframe_id;
  });
  CHECK(leaving != keyframes.end()) << "keyframe " << keyframe_id << " is not in the window";

  const std::unique_ptr<WindowGraph> graph = BuildWindowGraph(*window, terms, options.graph);
  std::vector<int> leaving_blocks;
  for (int i = 0; i < graph->FirstPointBlock(); ++i) {
    const FactorGraph::Block& block = graph->blocks()[i];
    if (block.kind->lifetime == BlockLifetime::kKeyframe && block.owner == keyframe_id) {
      leaving_blocks.push_back(i);
    }
  }
  const std::vector<bool> is_tied = TiedPoints(*graph);
  std::vector<bool> stays;
  for (const auto& host : keyframes) {
    for (const auto& point : host->points) {
      const size_t number = stays.size();
      stays.push_back(host->id != keyframe_id && IsSeenByNewestTwo(*window, *host, *point));
      if (stays.back()) continue;
      leaving_blocks.push_back(graph->FirstPointBlock() + static_cast<int>(number));
      if (is_tied[number] || !options.marginalization_prior) {
        result.points.push_back(MakeRetiredPoint(window->camera, *host, *point));
        ++result.marginalized_points;
      } else {
        ++result.dropped_points;
      }
    }
  }

  LinearPrior prior;
  if (options.marginalization_prior) {
    BlockMarginalization marginalization = MarginalizeBlocks(*graph, leaving_blocks);
    result.rank = marginalization.rank;
    graph->KeepFirstEstimates(marginalization.prior_blocks, window);
    prior = std::move(marginalization.prior);
  }
  window->prior = std::move(prior);
  size_t number = 0;
  for (const auto& host : keyframes) {
    auto& points = host->points;
    points.erase(
        std::remove_if(
            points.begin(), points.end(), [&](const auto& /*point*/) { return !stays[number++]; }),
        points.end());
  }
  keyframes.erase(leaving);
  return result;
}

std::vector<RetiredPoint> ForgetWindow(Window* window) {
  std::vector<RetiredPoint> points;
  for (const auto& keyframe : window->keyframes) {
    for (const auto& point : keyframe->points) {
      points.push_back(MakeRetiredPoint(window->camera, *keyframe, *point));
    }
  }
  window->keyframes.clear();
  for (StateBlock& state : window->states) state.first_estimate.reset();
  window->prior = {};
  return points;
}

namespace {

std::array<uint8_t, 3> ColourOf(const Keyframe& host, const PhotometricPatch& patch) {
  const cv::Mat& colour = host.frame->colour;
  if (colour.empty()) {
    const auto gray = cv::saturate_cast<uint8_t>(patch.intensity[kPatternCenter]);
    return {gray, gray, gray};
  }
  const auto& bgr = colour.at<cv::Vec3b>(static_cast<int>(std::lround(patch.px.y())),
                                         static_cast<int>(std::lround(patch.px.x())));
  return {bgr[2], bgr[1], bgr[0]};
}

}  // namespace

RetiredPoint MakeRetiredPoint(const PlenopticProjection& camera,
                              const Keyframe& host,
                              const Point& point) {
  return {host.id,
          UnprojectInverseDepth(camera, point.patch.px, point.rho).cast<float>(),
          point.patch.px.cast<float>(),
          static_cast<float>(point.rho_sigma),
          ColourOf(host, point.patch)};
}

}  // namespace prism
