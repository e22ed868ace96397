// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "prism/report/trajectory_plots.h"

namespace prism {

// One row an estimate: label, matched poses, coverage (%), ATE after SE3 and Sim3 (m), scale and
// its error (%), relative error over the interval (m, deg), e_s, e_r (deg), e_align (m). What could
// not be computed is "-". An estimate with several segments is followed by a row for each in the
// text table.
std::string FormatTextTable(const std::vector<EvaluatedTrajectory>& estimates);
// With a header line; fields with commas or quotes are quoted; what is missing is empty.
std::string FormatCsv(const std::vector<EvaluatedTrajectory>& estimates);
// Rows of a tabular (`a & b \\`), the header first; smallest errors are not marked.
std::string FormatLatexRows(const std::vector<EvaluatedTrajectory>& estimates);

}  // namespace prism
