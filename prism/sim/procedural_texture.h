// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace prism {

// Names of the textures MakeTexture can make: plaster (nearly blank), planks, bricks, tiles, wood,
// fabric, rug, painting, poster, books (a row of spines), leaves, asphalt, white.
const std::vector<std::string>& ProceduralTextureKinds();

// A texture of that kind, 8-bit BGR, `pixels` square, the same for the same seed: edges at the
// kind's own scale on top of noise of all scales down to a pixel. Precondition: a known kind and
// pixels >= 16.
cv::Mat MakeTexture(const std::string& kind, int pixels, uint64_t seed);

}  // namespace prism
