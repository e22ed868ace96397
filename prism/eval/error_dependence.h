// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

namespace prism {

// One measurement with truth.
struct ErrorSample {
  int frame = 0;     // errors within a frame are correlated, frames are taken as independent
  double error = 0;  // measured - true
  double sigma = 0;  // stated standard deviation, > 0
};

struct ErrorSummary {
  long count = 0;
  double median = 0;
  double trimmed_mean = 0;      // without the lowest and the highest tenth
  double robust_sigma = 0;      // 1.4826 MAD about the median
  double rms = 0;               // about 0
  double large_fraction = 0;    // |error| > `large_error`
  double normalized_sigma = 0;  // robust standard deviation of error / sigma, 1.4826 MAD about 0
};

// All 0 without samples.
ErrorSummary SummarizeErrors(const std::vector<ErrorSample>& samples, double large_error);

struct ErrorBinOptions {
  int bins = 6;              // of about equal counts
  bool is_discrete = false;  // a bin a value in place of `bins`
  double large_error = 0.02;
  int resamples = 200;  // of the bootstrap
  uint64_t seed = 1;    // of the bootstrap
};

// The errors of the samples with a feature in [low, high].
struct ErrorBin {
  double low = 0;     // NaN in the bin of samples without the feature
  double middle = 0;  // median of the feature
  double high = 0;
  ErrorSummary errors;
  // Standard errors are standard deviations over bootstrap samples of whole frames, which holds
  // correlation within frames; NaN with fewer than two frames. Frames that show the same things are
  // correlated as well: with few sequences they are too small.
  double median_standard_error = 0;
  double excess = 0;  // median - median of all samples
  double excess_standard_error = 0;
};

// How errors depend on a feature, one value a sample; NaN: the sample has none. Bins by rising
// value, samples without the feature last. Equal values share a bin, so that there may be fewer
// bins than asked for; none without samples. Deterministic.
// Preconditions: as many features as samples; bins, resamples > 0; frames >= 0.
std::vector<ErrorBin> BinErrors(const std::vector<ErrorSample>& samples,
                                const std::vector<double>& feature,
                                const ErrorBinOptions& options);

// What the errors of a frame have in common.
struct FrameSpread {
  int frames = 0;
  double mean_of_medians = 0;
  // Standard deviation from frame to frame (n - 1), of medians and of trimmed means; 0 with fewer
  // than two frames.
  double median_sigma = 0;
  double mean_sigma = 0;
};

// One summary a frame; frames without samples do not count.
FrameSpread SpreadOverFrames(const std::vector<ErrorSummary>& frames);

}  // namespace prism
