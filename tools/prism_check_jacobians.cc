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
#include "prism/io/atomic_file.h"
#include "prism/io/camera_file.h"
#include "prism/residual/jacobian_check.h"
#include "tools/tool_main.h"

DEFINE_string(camera, "calib", "A plenoptic camera file, or a folder of them.");
DEFINE_int32(samples, 200, "Random states per camera.");
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

void Print(const std::string& file, const JacobianCheckResult& result, double tolerance) {
  std::printf("\n%s: %d states\n", file.c_str(), result.valid_samples);
  std::printf("  %-22s %-16s %14s %14s %14s\n",
              "residual",
              "block",
              "vs autodiff",
              "vs numeric",
              "largest");
  for (const JacobianBlockCheck& block : result.blocks) {
    std::printf("  %-22s %-16s %14.3g %14.3g %14.3g  %s\n",
                block.residual.c_str(),
                block.block.c_str(),
                block.autodiff_error,
                block.numeric_error,
                block.largest_element,
                block.autodiff_error <= tolerance ? "agrees" : "DISAGREES");
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
    json["blocks"].push_back({{"residual", block.residual},
                              {"block", block.block},
                              {"autodiff_error", block.autodiff_error},
                              {"numeric_error", block.numeric_error},
                              {"largest_element", block.largest_element}});
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
  bool all_agree = true;
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const std::string& file : CameraFiles()) {
    const JacobianCheckResult result = CheckJacobians(ReadPlenopticCamera(file), options);
    Print(file, result, options.tolerance);
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
