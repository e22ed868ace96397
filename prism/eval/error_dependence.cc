// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/eval/error_dependence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <utility>

#include <glog/logging.h>

#include "prism/base/random.h"
#include "prism/base/statistics.h"

namespace prism {
namespace {

constexpr double kSigmaOverMad = 1.4826;  // of a Gaussian
constexpr double kTrimmed = 0.1;          // at each end

double Median(std::vector<double> values) { return Quantile(std::move(values), 0.5); }

double TrimmedMean(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto cut = static_cast<std::ptrdiff_t>(kTrimmed * static_cast<double>(values.size()));
  return std::accumulate(values.begin() + cut, values.end() - cut, 0.0) /
         static_cast<double>(static_cast<std::ptrdiff_t>(values.size()) - 2 * cut);
}

// n - 1 in the denominator; 0 for fewer than two values.
double StandardDeviation(const std::vector<double>& values) {
  const auto count = static_cast<double>(values.size());
  if (count < 2) return 0;
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
  double sum = 0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return std::sqrt(sum / (count - 1));
}

// The errors of a bin, frame by frame.
using ErrorsByFrame = std::vector<std::vector<double>>;

// Of the frames drawn, some perhaps several times; NaN without errors.
double MedianOfFrames(const ErrorsByFrame& errors, const std::vector<size_t>& drawn) {
  std::vector<double> all;
  for (const size_t frame : drawn) {
    all.insert(all.end(), errors[frame].begin(), errors[frame].end());
  }
  return all.empty() ? std::numeric_limits<double>::quiet_NaN() : Median(std::move(all));
}

// NaN if only one frame has errors.
void AddStandardErrors(const ErrorsByFrame& errors_of_all,
                       const std::vector<ErrorsByFrame>& errors_of_bins,
                       const ErrorBinOptions& options,
                       std::vector<ErrorBin>* bins) {
  const size_t frames = errors_of_all.size();
  std::vector<std::vector<double>> medians(bins->size()), excesses(bins->size());
  for (int k = 0; k < options.resamples; ++k) {
    std::mt19937_64 generator = SeededGenerator(options.seed, static_cast<uint64_t>(k));
    std::uniform_int_distribution<size_t> any_frame(0, frames - 1);
    std::vector<size_t> drawn(frames);
    for (size_t& frame : drawn) frame = any_frame(generator);
    const double median_of_all = MedianOfFrames(errors_of_all, drawn);
    for (size_t b = 0; b < bins->size(); ++b) {
      const double median = MedianOfFrames(errors_of_bins[b], drawn);
      if (std::isnan(median)) continue;
      medians[b].push_back(median);
      excesses[b].push_back(median - median_of_all);
    }
  }
  for (size_t b = 0; b < bins->size(); ++b) {
    const ErrorsByFrame& errors = errors_of_bins[b];
    const auto empty_frames =
        std::count_if(errors.begin(), errors.end(), [](const auto& of) { return of.empty(); });
    const bool is_known = frames - static_cast<size_t>(empty_frames) >= 2;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    (*bins)[b].median_standard_error = is_known ? StandardDeviation(medians[b]) : nan;
    (*bins)[b].excess_standard_error = is_known ? StandardDeviation(excesses[b]) : nan;
  }
}

// Indices of the samples of each bin, by rising feature; those without one last.
std::vector<std::vector<size_t>> SortIntoBins(const std::vector<double>& feature,
                                              const ErrorBinOptions& options) {
  std::vector<size_t> with, without;
  for (size_t i = 0; i < feature.size(); ++i) {
    (std::isnan(feature[i]) ? without : with).push_back(i);
  }
  std::stable_sort(
      with.begin(), with.end(), [&](size_t a, size_t b) { return feature[a] < feature[b]; });
  std::vector<std::vector<size_t>> bins;
  const size_t wanted = static_cast<size_t>(options.bins);
  for (size_t begin = 0, bin = 1; begin < with.size(); ++bin) {
    size_t end = options.is_discrete ? begin + 1 : with.size() * bin / wanted;
    if (end <= begin) continue;
    while (end < with.size() && feature[with[end]] == feature[with[end - 1]]) ++end;
    bins.emplace_back(with.begin() + static_cast<std::ptrdiff_t>(begin),
                      with.begin() + static_cast<std::ptrdiff_t>(end));
    begin = end;
  }
  if (!without.empty()) bins.push_back(without);
  return bins;
}

}  // namespace

ErrorSummary SummarizeErrors(const std::vector<ErrorSample>& samples, double large_error) {
  ErrorSummary summary;
  if (samples.empty()) return summary;
  std::vector<double> errors, deviations, normalized;
  double squares = 0;
  long large = 0;
  for (const ErrorSample& sample : samples) {
    errors.push_back(sample.error);
    normalized.push_back(std::abs(sample.error) / sample.sigma);
    squares += sample.error * sample.error;
    large += std::abs(sample.error) > large_error;
  }
  const auto count = static_cast<double>(samples.size());
  summary.count = static_cast<long>(samples.size());
  summary.median = Median(errors);
  for (const double error : errors) deviations.push_back(std::abs(error - summary.median));
  summary.trimmed_mean = TrimmedMean(std::move(errors));
  summary.robust_sigma = kSigmaOverMad * Median(std::move(deviations));
  summary.rms = std::sqrt(squares / count);
  summary.large_fraction = static_cast<double>(large) / count;
  summary.normalized_sigma = kSigmaOverMad * Median(std::move(normalized));
  return summary;
}

std::vector<ErrorBin> BinErrors(const std::vector<ErrorSample>& samples,
                                const std::vector<double>& feature,
                                const ErrorBinOptions& options) {
  CHECK_EQ(samples.size(), feature.size());
  CHECK_GT(options.bins, 0);
  CHECK_GT(options.resamples, 0);
  if (samples.empty()) return {};
  std::map<int, size_t> frames;  // to their place among those that have samples
  for (const ErrorSample& sample : samples) frames.emplace(sample.frame, frames.size());
  ErrorsByFrame errors_of_all(frames.size());
  for (const ErrorSample& sample : samples) {
    errors_of_all[frames.at(sample.frame)].push_back(sample.error);
  }
  const double median_of_all = SummarizeErrors(samples, options.large_error).median;
  std::vector<ErrorBin> bins;
  std::vector<ErrorsByFrame> errors_of_bins;
  for (const std::vector<size_t>& indices : SortIntoBins(feature, options)) {
    std::vector<ErrorSample> in_bin;
    errors_of_bins.emplace_back(frames.size());
    for (const size_t i : indices) {
      in_bin.push_back(samples[i]);
      errors_of_bins.back()[frames.at(samples[i].frame)].push_back(samples[i].error);
    }
    ErrorBin bin;
    bin.low = feature[indices.front()];
    bin.middle = feature[indices[(indices.size() - 1) / 2]];
    bin.high = feature[indices.back()];
    bin.errors = SummarizeErrors(in_bin, options.large_error);
    bin.excess = bin.errors.median - median_of_all;
    bins.push_back(bin);
  }
  AddStandardErrors(errors_of_all, errors_of_bins, options, &bins);
  return bins;
}

FrameSpread SpreadOverFrames(const std::vector<ErrorSummary>& frames) {
  std::vector<double> medians, means;
  for (const ErrorSummary& frame : frames) {
    if (frame.count == 0) continue;
    medians.push_back(frame.median);
    means.push_back(frame.trimmed_mean);
  }
  FrameSpread spread;
  spread.frames = static_cast<int>(medians.size());
  if (medians.empty()) return spread;
  spread.mean_of_medians =
      std::accumulate(medians.begin(), medians.end(), 0.0) / static_cast<double>(medians.size());
  spread.median_sigma = StandardDeviation(medians);
  spread.mean_sigma = StandardDeviation(means);
  return spread;
}

}  // namespace prism
