// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace prism {

// Rows of matrices below are filled up with zeros to a multiple of this.
inline constexpr size_t kGramLanes = 4;

// A^T A of A (num_rows x width, row-major, rows of `stride` numbers), its upper triangle, into rows
// of the same stride; what is below the triangle is not defined.
void UpperGram(const double* A, size_t num_rows, size_t width, size_t stride, double* gram);

}  // namespace prism
