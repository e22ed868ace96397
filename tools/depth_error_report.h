// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "prism/eval/error_dependence.h"
#include "prism/lightfield/depth_conditions.h"

namespace prism {

// The points of one frame: errors of their measured 1/v with the conditions, one for each.
struct DepthErrorFrame {
  int number = 0;  // in its sequence
  std::vector<ErrorSample> errors;
  std::vector<DepthConditions> conditions;
};

struct DepthErrorSequence {
  std::string folder;
  std::vector<DepthErrorFrame> frames;
};

// Errors of all points over one feature.
struct DepthErrorDependence {
  std::string name;   // key in the JSON file
  std::string title;  // with unit
  std::vector<std::string> bin_names;
  std::vector<ErrorBin> bins;
};

// Features that are the same for all points are left out.
std::vector<DepthErrorDependence> AnalyzeDepthErrors(
    const std::vector<DepthErrorSequence>& sequences);

// Frame by frame, then feature by feature; errors in 0.001 of 1/v.
std::string FormatDepthErrors(const std::vector<DepthErrorSequence>& sequences,
                              const std::vector<DepthErrorDependence>& dependences);

// Errors in 1/v.
nlohmann::ordered_json DepthErrorsToJson(const std::vector<DepthErrorSequence>& sequences,
                                         const std::vector<DepthErrorDependence>& dependences);

// One page as SVG and PNG, a panel a feature, without bins of a few points.
void PlotDepthErrors(const std::string& path_without_extension,
                     const std::vector<DepthErrorDependence>& dependences);

}  // namespace prism
