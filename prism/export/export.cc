// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/export/export.h"

#include <algorithm>
#include <iterator>

#include <glog/logging.h>

#include "prism/export/colmap.h"
#include "prism/export/dense_points.h"
#include "prism/export/euroc.h"
#include "prism/export/kitti.h"
#include "prism/export/mcap.h"
#include "prism/export/nerfstudio.h"
#include "prism/export/ply.h"

namespace prism {
namespace {

struct ExportFormat {
  const char* name;
  std::string (*write)(const std::string& folder, const ExportRun& run);
};

constexpr ExportFormat kFormats[] = {{"colmap", WriteColmap},
                                     {"nerfstudio", WriteNerfstudio},
                                     {"kitti", WriteKitti},
                                     {"euroc", WriteEuroc},
                                     {"mcap", WriteMcap},
                                     {"ply", WriteSparsePly},
                                     {"dense", WriteDensePly}};

const ExportFormat* Find(const std::string& name) {
  const auto* found = std::find_if(std::begin(kFormats),
                                   std::end(kFormats),
                                   [&](const ExportFormat& format) { return name == format.name; });
  return found == std::end(kFormats) ? nullptr : found;
}

}  // namespace

std::string ExportNames() {
  std::string names;
  const size_t count = std::size(kFormats);
  for (size_t i = 0; i < count; ++i) {
    if (i > 0) names += i + 1 < count ? ", " : " or ";
    names += kFormats[i].name;
  }
  return names;
}

bool IsExportName(const std::string& name) { return Find(name) != nullptr; }

std::string WriteExports(const std::vector<std::string>& names,
                         const std::string& folder,
                         const ExportRun& run) {
  std::string report;
  for (const std::string& name : names) {
    const ExportFormat* format = Find(name);
    CHECK(format != nullptr) << name;
    report += name + ": " + format->write(folder, run) + "\n";
  }
  return report;
}

}  // namespace prism
