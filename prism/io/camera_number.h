// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace prism {

// A finite number such as `-2.5e-005` and nothing else; InputError(file, found, expected) if not.
double ParseCameraNumber(const std::string& text,
                         const std::string& file,
                         const std::string& expected);

// A side of an image: a whole number of pixels up to 65535; InputError naming `file` if not.
int ParsePixelCount(double value, const std::string& file);

}  // namespace prism
