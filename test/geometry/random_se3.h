// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>

#include "prism/geometry/se3.h"

namespace prism {

inline Vector6d RandomTangent(std::mt19937_64* generator) {
  std::normal_distribution<double> normal;
  Vector6d tangent;
  for (int i = 0; i < 6; ++i) tangent(i) = normal(*generator) * (i < 3 ? 1 : 0.5);
  return tangent;
}

inline SE3 RandomSE3(std::mt19937_64* generator) { return SE3::Exp(RandomTangent(generator)); }

}  // namespace prism
