// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include <gflags/gflags.h>
#include <nlohmann/json.hpp>

#include "prism/base/error.h"
#include "prism/factors/default_terms.h"
#include "prism/io/atomic_file.h"
#include "prism/io/camera_file.h"
#include "prism/verify/jacobian_check.h"
#include "tools/tool_main.h"

DEFINE_string(camera, "calib", "A plenoptic camera file, or a folder of them.");
DEFINE_int32(samples, 200, "Random states per camera.");
DEFINE_string(focused_image,
              "virtual_points",
              "What the focused images show: virtual_points (the supplement) or chief_rays.");
DEFINE_uint32(seed, 0, "Seed of the random states.");
DEFINE_string(json, "", "File for the result as JSON; empty: none.");

namespace prism {
namespace {

std::vector<std::string> CameraFiles() {
  namespace fs = std::filesystem;
  if (!fs::is_directory(FLAGS_camera)) return {FLAGS_camera};
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(FLAGS_camera)) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  if (files.empty()) throw InputError(FLAGS_camera, "no .yaml file", "camera files");
  return files;
}

void Print(const std::string& file,
           const JacobianCheckResult& result,
           const JacobianCheckOptions& options) {
  std::printf("\n%s: %d states\n", file.c_str(), result.valid_samples);
  std::printf("  %-32s %-24s %12s %12s %12s\n",
              "residual",
              "block",
              "vs autodiff",
              "vs numeric",
              "largest");
  for (const JacobianBlockCheck& block : result.blocks) {
    char autodiff[32] = "-";
    if (block.autodiff_error) {
      std::snprintf(autodiff, sizeof(autodiff), "%.3g", *block.autodiff_error);
    }
    std::printf("  %-32s %-24s %12s %12.3g %12.3g  %s\n",
                block.residual.c_str(),
                block.block.c_str(),
                autodiff,
                block.numeric_error,
                block.largest_element,
                Agrees(block, options) ? "agrees" : "DISAGREES");
  }
  std::printf("  d x'_V / d pose at (0.3, -0.2, 2.5) m as the supplement prints it:\n");
  std::printf("  %-8s %-14s %14s %14s %14s\n", "Eq.", "element", "true", "printed", "printed/true");
  for (const PrintedElement& element : result.printed) {
    std::printf("  %-8s %-14s %14.6g %14.6g %14.6g\n",
                element.equation.c_str(),
                element.element.c_str(),
                element.analytic,
                element.printed,
                element.printed / element.analytic);
  }
}

nlohmann::ordered_json ToJson(const std::string& file, const JacobianCheckResult& result) {
  nlohmann::ordered_json json;
  json["camera"] = file;
  json["states"] = result.valid_samples;
  json["agrees"] = result.agrees;
  for (const JacobianBlockCheck& block : result.blocks) {
    nlohmann::ordered_json entry = {{"residual", block.residual}, {"block", block.block}};
    if (block.autodiff_error) entry["autodiff_error"] = *block.autodiff_error;
    entry["numeric_error"] = block.numeric_error;
    entry["largest_element"] = block.largest_element;
    json["blocks"].push_back(std::move(entry));
  }
  for (const PrintedElement& element : result.printed) {
    json["printed"].push_back({{"equation", element.equation},
                               {"element", element.element},
                               {"true", element.analytic},
                               {"printed", element.printed}});
  }
  return json;
}

ExitStatus Run() {
  JacobianCheckOptions options;
  options.samples = FLAGS_samples;
  options.seed = FLAGS_seed;
  if (FLAGS_samples < 1) throw InputError("--samples", std::to_string(FLAGS_samples), "1 or more");
  FocusedImage focused_image;
  if (!ParseFocusedImage(FLAGS_focused_image, &focused_image)) {
    throw OptionError("focused_image", "'" + FLAGS_focused_image + "'", kFocusedImages);
  }
  bool all_agree = true;
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const std::string& file : CameraFiles()) {
    PlenopticCamera camera = ReadMetricCamera(file);
    camera.focused_image = focused_image;
    const JacobianCheckResult result = CheckJacobians(camera, MakeDefaultTerms({}), options);
    Print(file, result, options);
    json.push_back(ToJson(file, result));
    all_agree &= result.agrees;
  }
  if (!FLAGS_json.empty()) WriteTextAtomically(FLAGS_json, json.dump(1) + "\n");
  std::printf("\n%s\n", all_agree ? "all blocks agree" : "some blocks DISAGREE");
  return all_agree ? kExitDone : kExitRunFailed;
}

}  // namespace
}  // namespace prism

int main(int argc, char** argv) {
  return prism::RunTool({"prism_check_jacobians",
                         "analytic Jacobians of every residual against Ceres' automatic "
                         "differentiation and central differences",
                         "[--camera=FILE or DIR] [--samples=N] [--json=FILE]",
                         "prism_check_jacobians --camera=calib"},
                        argc,
                        argv,
                        prism::Run);
}
