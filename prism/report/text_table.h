// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace prism {

// Rows of equal length as text, columns as wide as their widest cell; the first column stands to
// the left, the others to the right. Empty for no rows.
std::string FormatColumns(const std::vector<std::vector<std::string>>& rows);

}  // namespace prism
