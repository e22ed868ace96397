// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "prism/export/export_run.h"

namespace prism {

// Names of all formats, as in "colmap, nerfstudio or kitti".
std::string ExportNames();

bool IsExportName(const std::string& name);

// Writes a run into the folder in each of the formats; returns "NAME: what was written" of each, a
// line each. Precondition: names that IsExportName knows. Throws InputError if a file cannot be
// written.
std::string WriteExports(const std::vector<std::string>& names,
                         const std::string& folder,
                         const ExportRun& run);

}  // namespace prism
