// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/map/place_store.h"

#include <cmath>
#include <iterator>
#include <utility>
namespace prism {

void PlaceStore::Add(Place place, const Distance& distance) {
  const int id = place.keyframe_id;
  places_[id] = std::move(place);
  if (static_cast<int>(places_.size()) <= max_places_) return;
  double closest = INFINITY;
  auto leaving = places_.begin();
  for (auto first = places_.begin(); first != places_.end(); ++first) {
    for (auto second = std::next(first); second != places_.end(); ++second) {
      const double separation = distance(first->second, second->second);
      if (separation < closest) {
        closest = separation;
        leaving = second;
      }
    }
  }
  places_.erase(leaving);
}

}  // namespace prism
