// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace prism {

// How much the patches of one point differ from lens to lens where they match, as a variance in
// that of the noise. Noise is one part. The other grows with contrast: compression, demosaicing,
// resampling and micro lenses that are not where they are said to be misplace texture by a share of
// a pixel, and so change it by that times its gradient.
struct MatchMisfit {
  double noise = 1;       // part at no contrast
  double share_px = 0.1;  // raw px, standard deviation in x and in y

  // `contrast`: squared gradient over the variance of the noise, 1/px^2.
  double Expect(double contrast) const { return noise + share_px * share_px * contrast; }
};

struct MatchSample {
  float contrast = 0;
  float residual = 0;  // mean square over the variance of the noise
};

// The misfit of a frame from matches of which some are wrong: a line through the lower quartiles of
// the residuals of eight classes of contrast, brought to the median. Few samples: the default.
MatchMisfit FitMisfit(std::vector<MatchSample> samples);

}  // namespace prism
