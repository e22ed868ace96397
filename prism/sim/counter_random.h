// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace prism {

// Random numbers that depend on where they are used, not on who drew before: the n-th number of
// (seed, stream, index), so that an image is the same for any number of threads. The mixer is the
// finaliser of SplitMix64 (Steele, Lea, Flood: Fast splittable pseudorandom number generators,
// OOPSLA 2014).
class CounterRandom {
 public:
  CounterRandom(uint64_t seed, uint64_t stream, uint64_t index)
      : state_(Mix(Mix(Mix(seed) + stream) + index)) {}

  // Uniform in [0, 1), 24 bits.
  float Uniform() { return static_cast<float>(Next() >> 40) * 0x1p-24f; }

  uint64_t Next() { return Mix(state_ += 0x9e3779b97f4a7c15ull); }

 private:
  static uint64_t Mix(uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
  }

  uint64_t state_;
};

}  // namespace prism
