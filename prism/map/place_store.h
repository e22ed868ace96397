// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>

#include "prism/scene/place.h"

namespace prism {

// The places of a map, by keyframe id: at most so many. One more, and the place that the others
// show best is forgotten: of the two that are closest to each other (distance over the median
// distance of what they show, plus angle between their views) the younger one.
class PlaceStore {
 public:
  // Distance of two places; INFINITY where their poses have nothing in common.
  using Distance = std::function<double(const Place&, const Place&)>;

  explicit PlaceStore(int max_places) : max_places_(max_places) {}

  void Add(Place place, const Distance& distance);
  const std::map<int, Place>& places() const { return places_; }

 private:
  int max_places_;
  std::map<int, Place> places_;
};

}  // namespace prism
