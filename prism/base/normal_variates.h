// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace prism {

// Standard normal variates for a noise on every pixel: each takes 16 bits of the generator, which
// choose one of 65,536 equally likely values, the quantiles (k + 0.5) / 65,536. They have a
// variance of 0.99998 and lie within 4.33.
class NormalVariates {
 public:
  explicit NormalVariates(const std::mt19937_64& generator) : generator_(generator) {}

  // The next `count` values.
  void Fill(float* values, size_t count);

 private:
  std::mt19937_64 generator_;
  std::vector<uint16_t> choices_;  // of one call
};

}  // namespace prism
