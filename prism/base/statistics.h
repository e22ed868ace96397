// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace prism {

// Value at quantile q in [0, 1] (nearest rank); 0 for an empty vector.
double Quantile(std::vector<double> values, double q);

// The median, of an even number of values the larger of the two in the middle. Precondition: not
// empty.
double UpperMedian(std::vector<double> values);

}  // namespace prism
