// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <random>

namespace prism {

// A generator for stream `stream` of a run seeded with `seed`. Streams (a frame number, say) are
// independent of each other, so that frame 100 gets the same noise whether or not frame 99 was
// read.
inline std::mt19937_64 SeededGenerator(uint64_t seed, uint64_t stream) {
  std::seed_seq sequence{static_cast<uint32_t>(seed),
                         static_cast<uint32_t>(seed >> 32),
                         static_cast<uint32_t>(stream),
                         static_cast<uint32_t>(stream >> 32)};
  return std::mt19937_64(sequence);
}

}  // namespace prism
