// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/depth_error_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "prism/report/plot.h"
#include "prism/report/text_table.h"

namespace prism {
namespace {

constexpr double kLargeError = 0.02;  // of 1/v
constexpr int kPlotColumns = 3;
constexpr int kMinPointsPlotted = 20;  // in a bin

struct Feature {
  std::string name;
  std::string title;
  std::function<double(const DepthConditions&, const ErrorSample&)> value;  // NaN: none
  int bins = 6;                                                             // 0: one a value
  std::string without = "none";  // name of the bin of points without it
  std::function<std::string(double)> name_of_value = nullptr;  // of discrete ones
};

std::string Text(const char* format, double value) {
  char text[48];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

std::string TypesOfMask(double mask) {
  std::string types;
  for (int type = 0; (1 << type) <= static_cast<int>(mask); ++type) {
    if ((static_cast<int>(mask) >> type & 1) == 0) continue;
    types += (types.empty() ? "" : "+") + std::to_string(type);
  }
  return types;
}

std::vector<Feature> Features() {
  using Conditions = DepthConditions;
  const auto of = [](double Conditions::*member) {
    return
        [member](const Conditions& conditions, const ErrorSample&) { return conditions.*member; };
  };
  const auto type = [](double value) { return Text("%.0f", value); };
  return {
      {"true_inverse_virtual_depth", "true 1/v", of(&Conditions::true_inverse_virtual_depth)},
      {"distance_m", "distance (m)", of(&Conditions::distance_m)},
      {"contrast", "gradient (a px) over noise", of(&Conditions::contrast)},
      {"texture_period_px", "texture period (raw px)", of(&Conditions::texture_period_px)},
      {"lens_axis_angle_deg",
       "gradient to lens axis (degrees)",
       of(&Conditions::lens_axis_angle_deg)},
      {"depth_edge_distance_near_px",
       "distance to a depth edge, near side of it (px)",
       [](const Conditions& c, const ErrorSample&) {
         return c.depth_edge_distance_px > 0 ? c.depth_edge_distance_px : NAN;
       },
       5,
       "others"},
      {"depth_edge_distance_far_px",
       "distance to a depth edge, far side of it (px)",
       [](const Conditions& c, const ErrorSample&) {
         return c.depth_edge_distance_px < 0 ? -c.depth_edge_distance_px : NAN;
       },
       5,
       "others"},
      {"image_radius_px", "distance from the image centre (px)", of(&Conditions::image_radius_px)},
      {"sharpest_lens_type",
       "lens type nearest to its focus",
       [](const Conditions& c, const ErrorSample&) { return c.sharpest_type; },
       0,
       "",
       type},
      {"lens_types_used",
       "lens types compared",
       [](const Conditions& c, const ErrorSample&) { return c.types_used; },
       0,
       "",
       TypesOfMask},
      {"view_radius_px", "mean radius of the views (raw px)", of(&Conditions::view_radius_px)},
      {"chief_view_radius_px",
       "radius of the view at the chief ray (raw px)",
       of(&Conditions::chief_view_radius_px)},
      {"stated_sigma",
       "stated standard deviation of 1/v",
       [](const Conditions&, const ErrorSample& error) { return error.sigma; },
       3},
      {"slant", "slant (1/v a px)", of(&Conditions::slant), 6, "edge"},
  };
}

std::vector<std::string> BinNames(const Feature& feature, const std::vector<ErrorBin>& bins) {
  std::vector<std::string> names;
  for (const ErrorBin& bin : bins) {
    names.push_back(std::isnan(bin.middle)  ? feature.without
                    : feature.name_of_value ? feature.name_of_value(bin.middle)
                                            : Text("%.3g", bin.middle));
  }
  return names;
}

// In 0.001 of 1/v.
std::string Milli(double error) { return Text("%+.2f", 1000 * error); }
std::string MilliSigma(double sigma) { return Text("%.2f", 1000 * sigma); }

const std::vector<std::string> kSummaryTitles = {
    "points", "median", "mean", "sigma", "RMS", ">0.02", "norm"};

std::vector<std::string> SummaryCells(const ErrorSummary& summary) {
  return {std::to_string(summary.count),
          Milli(summary.median),
          Milli(summary.trimmed_mean),
          MilliSigma(summary.robust_sigma),
          MilliSigma(summary.rms),
          Text("%.3f", summary.large_fraction),
          Text("%.2f", summary.normalized_sigma)};
}

std::vector<std::string> Row(std::vector<std::string> first, const std::vector<std::string>& rest) {
  first.insert(first.end(), rest.begin(), rest.end());
  return first;
}

std::vector<ErrorSummary> SummarizeFrames(const DepthErrorSequence& sequence) {
  std::vector<ErrorSummary> summaries;
  for (const DepthErrorFrame& frame : sequence.frames) {
    summaries.push_back(SummarizeErrors(frame.errors, kLargeError));
  }
  return summaries;
}

std::vector<ErrorSummary> SummarizeFrames(const std::vector<DepthErrorSequence>& sequences) {
  std::vector<ErrorSummary> all;
  for (const DepthErrorSequence& sequence : sequences) {
    const std::vector<ErrorSummary> summaries = SummarizeFrames(sequence);
    all.insert(all.end(), summaries.begin(), summaries.end());
  }
  return all;
}

std::vector<ErrorSample> Pool(const std::vector<DepthErrorSequence>& sequences) {
  std::vector<ErrorSample> samples;
  for (const DepthErrorSequence& sequence : sequences) {
    for (const DepthErrorFrame& frame : sequence.frames) {
      samples.insert(samples.end(), frame.errors.begin(), frame.errors.end());
    }
  }
  return samples;
}

std::vector<std::string> SpreadCells(const std::string& name, const FrameSpread& spread) {
  return {name,
          std::to_string(spread.frames),
          Milli(spread.mean_of_medians),
          MilliSigma(spread.median_sigma),
          MilliSigma(spread.mean_sigma)};
}

nlohmann::ordered_json ToJson(const ErrorSummary& summary) {
  return {{"points", summary.count},
          {"median", summary.median},
          {"trimmed_mean", summary.trimmed_mean},
          {"robust_sigma", summary.robust_sigma},
          {"rms", summary.rms},
          {"fraction_above_0_02", summary.large_fraction},
          {"normalized_sigma", summary.normalized_sigma}};
}

nlohmann::ordered_json ToJson(const FrameSpread& spread) {
  return {{"frames", spread.frames},
          {"mean_of_medians", spread.mean_of_medians},
          {"sigma_of_medians", spread.median_sigma},
          {"sigma_of_means", spread.mean_sigma}};
}

}  // namespace

std::vector<DepthErrorDependence> AnalyzeDepthErrors(
    const std::vector<DepthErrorSequence>& sequences) {
  const std::vector<ErrorSample> samples = Pool(sequences);
  std::vector<DepthErrorDependence> dependences;
  for (const Feature& feature : Features()) {
    std::vector<double> values;
    for (const DepthErrorSequence& sequence : sequences) {
      for (const DepthErrorFrame& frame : sequence.frames) {
        for (size_t i = 0; i < frame.errors.size(); ++i) {
          values.push_back(feature.value(frame.conditions[i], frame.errors[i]));
        }
      }
    }
    ErrorBinOptions options;
    options.is_discrete = feature.bins == 0;
    if (feature.bins > 0) options.bins = feature.bins;
    options.large_error = kLargeError;
    const std::vector<ErrorBin> bins = BinErrors(samples, values, options);
    if (bins.size() < 2) continue;
    dependences.push_back({feature.name, feature.title, BinNames(feature, bins), bins});
  }
  return dependences;
}

std::string FormatDepthErrors(const std::vector<DepthErrorSequence>& sequences,
                              const std::vector<DepthErrorDependence>& dependences) {
  std::string text = "Errors of 1/v (measured - true) in 0.001\n\n";
  std::vector<std::vector<std::string>> rows = {Row({"sequence", "frame"}, kSummaryTitles)};
  for (const DepthErrorSequence& sequence : sequences) {
    const std::vector<ErrorSummary> frames = SummarizeFrames(sequence);
    for (size_t i = 0; i < frames.size(); ++i) {
      rows.push_back(Row({sequence.folder, std::to_string(sequence.frames[i].number)},
                         SummaryCells(frames[i])));
    }
  }
  rows.push_back(Row({"all", ""}, SummaryCells(SummarizeErrors(Pool(sequences), kLargeError))));
  text += FormatColumns(rows);

  rows = {
      {"from frame to frame", "frames", "mean of medians", "sigma of medians", "sigma of means"}};
  for (const DepthErrorSequence& sequence : sequences) {
    rows.push_back(SpreadCells(sequence.folder, SpreadOverFrames(SummarizeFrames(sequence))));
  }
  rows.push_back(SpreadCells("all", SpreadOverFrames(SummarizeFrames(sequences))));
  text += "\n" + FormatColumns(rows);

  text += "\n+-: standard error by a bootstrap of frames; excess: over the median of all points\n";
  for (const DepthErrorDependence& dependence : dependences) {
    rows = {Row({dependence.title}, kSummaryTitles)};
    rows[0].insert(rows[0].begin() + 3, "+-");
    rows[0].insert(rows[0].end(), {"excess", "+-"});
    for (size_t b = 0; b < dependence.bins.size(); ++b) {
      const ErrorBin& bin = dependence.bins[b];
      std::vector<std::string> row = Row({dependence.bin_names[b]}, SummaryCells(bin.errors));
      row.insert(row.begin() + 3, MilliSigma(bin.median_standard_error));
      row.insert(row.end(), {Milli(bin.excess), MilliSigma(bin.excess_standard_error)});
      rows.push_back(row);
    }
    text += "\n" + FormatColumns(rows);
  }
  return text;
}

nlohmann::ordered_json DepthErrorsToJson(const std::vector<DepthErrorSequence>& sequences,
                                         const std::vector<DepthErrorDependence>& dependences) {
  nlohmann::ordered_json json;
  json["all"] = ToJson(SummarizeErrors(Pool(sequences), kLargeError));
  json["frame_to_frame"] = ToJson(SpreadOverFrames(SummarizeFrames(sequences)));
  for (const DepthErrorSequence& sequence : sequences) {
    const std::vector<ErrorSummary> summaries = SummarizeFrames(sequence);
    nlohmann::ordered_json frames = nlohmann::ordered_json::array();
    for (size_t i = 0; i < summaries.size(); ++i) {
      frames.push_back({{"frame", sequence.frames[i].number}});
      frames.back().update(ToJson(summaries[i]));
    }
    json["sequences"].push_back({{"folder", sequence.folder},
                                 {"frame_to_frame", ToJson(SpreadOverFrames(summaries))},
                                 {"frames", frames}});
  }
  for (const DepthErrorDependence& dependence : dependences) {
    nlohmann::ordered_json bins = nlohmann::ordered_json::array();
    for (size_t b = 0; b < dependence.bins.size(); ++b) {
      const ErrorBin& bin = dependence.bins[b];
      bins.push_back({{"name", dependence.bin_names[b]},
                      {"low", bin.low},
                      {"middle", bin.middle},
                      {"high", bin.high}});
      bins.back().update(ToJson(bin.errors));
      bins.back().update({{"median_standard_error", bin.median_standard_error},
                          {"excess", bin.excess},
                          {"excess_standard_error", bin.excess_standard_error}});
    }
    json["features"][dependence.name] = {{"title", dependence.title}, {"bins", bins}};
  }
  return json;
}

void PlotDepthErrors(const std::string& path_without_extension,
                     const std::vector<DepthErrorDependence>& dependences) {
  std::vector<Plot> plots;
  for (const DepthErrorDependence& dependence : dependences) {
    PlotSeries median, sigma;
    median.label = "median, standard error";
    sigma.label = "robust sigma";
    sigma.is_reference = true;
    Plot plot;
    for (size_t b = 0; b < dependence.bins.size(); ++b) {
      const ErrorBin& bin = dependence.bins[b];
      if (bin.errors.count < kMinPointsPlotted) continue;
      const auto x = static_cast<double>(plot.x_categories.size());
      median.points.push_back({x, 1000 * bin.errors.median});
      median.y_errors.push_back(1000 * bin.median_standard_error);
      sigma.points.push_back({x, 1000 * bin.errors.robust_sigma});
      plot.x_categories.push_back(dependence.bin_names[b]);
    }
    plot.title = "Error of 1/v against " + dependence.title;
    plot.x_label = dependence.title + ", medians of bins";
    plot.y_label = "measured - true 1/v (0.001)";
    plot.series = {median, sigma};
    plot.y_from_zero = true;
    plots.push_back(plot);
  }
  WritePlotPage(path_without_extension, plots, kPlotColumns);
}

}  // namespace prism
