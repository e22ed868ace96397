// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

namespace prism {

// How many measurements stand for one: depths measured at neighbouring pixels come from the same
// raw pixels and err together. With errors correlated by exp(-d^2 / (2 correlation^2)) over the
// distance d, the sum over a group of n pixels close together has n times the variance it would
// have if they were independent. For each pixel the sum of its correlations with all, itself
// included; a measurement's variance times it, all taken as independent, weighs together what they
// are worth together. 1 if `correlation_px` is 0.
std::vector<double> NumSharingDepth(const std::vector<Eigen::Vector2i>& pixels,
                                    double correlation_px);

}  // namespace prism
