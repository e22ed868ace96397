// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/lightfield/depth_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glog/logging.h>

#include "prism/lightfield/defocus_match.h"
#include "prism/lightfield/patch_kernel.h"
#include "prism/lightfield/patch_samples.h"

namespace prism {
namespace {

constexpr int kMaxSearched = 5;   // lenses, nearest to the chief ray first
constexpr float kMinFreedom = 4;  // PatchSums::freedom of what is compared at all
constexpr float kUnseen = 1e30f;  // cost where it is less

class Sweep {
 public:
  Sweep(const PreparedRaw& raw,
        const SmoothRows& rows,
        const LensTable& lenses,
        const SweepRange& range,
        float X,
        float Y)
      : raw_(raw),
        rows_(rows),
        lenses_(lenses),
        range_(range),
        count_(range.count()),
        X_(X),
        Y_(Y) {}

  std::optional<SweepMinimum> Minimum(float noise);

 private:
  struct Hypothesis {
    float cost = kUnseen;  // mean square
    float freedom = 0;
    bool is_exact = false;
  };

  float WOf(int h) const { return range_.min_w + range_.step * static_cast<float>(h); }
  bool IsSeen(int h) const { return hypotheses_[h].cost < kUnseen; }
  bool IsBracketed(int h) const {
    return h > 0 && h + 1 < count_ && IsSeen(h - 1) && IsSeen(h + 1);
  }
  int ViewsAt(int h, const DefocusMatch& match, LensView* views) const {
    return lenses_.ViewsOf(
        X_, Y_, WOf(h), lenses_.radius_px() - 2, kPatchMargin, match.types(), kMaxSearched, views);
  }
  DefocusMatch MatchAt(int h) const {
    return DefocusMatch(lenses_.focus_of_type(), lenses_.DefocusVariance(), WOf(h));
  }
  void Compare(int h);
  void CompareExactly(int h);
  // The exact minimum at or beside h; -1 if it has none around it.
  int ExactMinimum(int h);
  bool IsAmbiguous(int best, float coarse_cost, float noise);

  const PreparedRaw& raw_;
  const SmoothRows& rows_;
  const LensTable& lenses_;
  const SweepRange& range_;
  const int count_;
  const float X_, Y_;
  std::array<Hypothesis, SweepRange::kMaxHypotheses> hypotheses_;
};

void Sweep::Compare(int h) {
  const DefocusMatch match = MatchAt(h);
  LensView views[kMaxSearched];
  const int count = ViewsAt(h, match, views);
  if (count < 2) return;
  CoarseSample samples[kMaxSearched];
  PlaceCoarseSamples(raw_, rows_, lenses_, match, views, count, samples);
  const PatchSums sums = SumCoarsePatchCosts(samples, count, raw_.gray.width());
  if (sums.freedom < kMinFreedom) return;
  hypotheses_[h] = {sums.cost / sums.freedom, sums.freedom, false};
}

// Precondition: IsSeen(h).
void Sweep::CompareExactly(int h) {
  if (hypotheses_[h].is_exact) return;
  const DefocusMatch match = MatchAt(h);
  LensView views[kMaxSearched];
  const int count = ViewsAt(h, match, views);
  PatchSample samples[kMaxSearched];
  PlaceSamples(raw_, rows_, lenses_, match, views, count, samples);
  const PatchSums sums = SumPatchCosts(samples, count, raw_.gray.width());
  hypotheses_[h] = {sums.freedom > 0 ? sums.cost / sums.freedom : kUnseen, sums.freedom, true};
}

int Sweep::ExactMinimum(int h) {
  constexpr int kMaxMoves = 2;
  for (int move = 0; move <= kMaxMoves && IsBracketed(h); ++move) {
    for (int k = h - 1; k <= h + 1; ++k) CompareExactly(k);
    const float below = hypotheses_[h - 1].cost, above = hypotheses_[h + 1].cost;
    if (hypotheses_[h].cost <= std::min(below, above)) return h;
    h += below < above ? -1 : 1;
  }
  return -1;
}

bool Sweep::IsAmbiguous(int best, float coarse_cost, float noise) {
  const float cost = hypotheses_[best].cost;
  const float least = range_.ambiguity * std::max(cost, noise * noise);
  // What half pixels may add to the cost of another minimum, by what they added to this one.
  const float slack = 2 * std::max(coarse_cost - cost, 0.0f);
  const auto excess = [&](const Hypothesis& other) { return other.freedom * (other.cost - cost); };
  for (int h = 0; h < count_; ++h) {
    const Hypothesis& other = hypotheses_[h];
    if (std::abs(h - best) <= 2 || !IsSeen(h)) continue;
    if (!other.is_exact && excess(other) - other.freedom * slack < least) CompareExactly(h);
    if (excess(other) < least) return true;
  }
  return false;
}

std::optional<SweepMinimum> Sweep::Minimum(float noise) {
  int best = 0;
  int last = 0;  // seen
  for (int h = 0; h < count_; ++h) {
    Compare(h);
    if (IsSeen(h)) last = h;
    if (hypotheses_[h].cost < hypotheses_[best].cost) best = h;
  }
  // Fewer lenses see a point the larger its 1/v: a minimum must be bracketed, or the best one may
  // lie where there is nothing to compare.
  if (!IsBracketed(best)) return std::nullopt;
  const float coarse_cost = hypotheses_[best].cost;
  best = ExactMinimum(best);
  if (best < 1 || IsAmbiguous(best, coarse_cost, noise)) return std::nullopt;
  // The vertex of the parabola through the three costs: started from a grid value, what is refined
  // would depend on which one was near.
  const float below = hypotheses_[best - 1].cost - hypotheses_[best].cost;
  const float above = hypotheses_[best + 1].cost - hypotheses_[best].cost;
  const float vertex = below + above > 0 ? 0.5f * (below - above) / (below + above) : 0.0f;
  return SweepMinimum{WOf(best) + range_.step * vertex, WOf(last)};
}

}  // namespace

int SweepRange::count() const { return 1 + static_cast<int>(std::floor((max_w - min_w) / step)); }

std::optional<SweepMinimum> SweepInverseVirtualDepth(const PreparedRaw& raw,
                                                     const SmoothRows& rows,
                                                     const LensTable& lenses,
                                                     const SweepRange& range,
                                                     float noise,
                                                     float X,
                                                     float Y) {
  DCHECK_LE(range.count(), SweepRange::kMaxHypotheses);
  return Sweep(raw, rows, lenses, range, X, Y).Minimum(noise);
}

}  // namespace prism
