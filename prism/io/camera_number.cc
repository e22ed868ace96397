// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/camera_number.h"

#include <charconv>
#include <cmath>
#include <sstream>

#include "prism/base/error.h"

namespace prism {

double ParseCameraNumber(const std::string& text,
                         const std::string& file,
                         const std::string& expected) {
  const size_t begin = text.find_first_not_of(" \t\r\n+");
  const size_t end = text.find_last_not_of(" \t\r\n");
  double value = 0;
  if (begin != std::string::npos) {
    const char* last = text.data() + end + 1;
    const auto [stop, error] = std::from_chars(text.data() + begin, last, value);
    if (error == std::errc() && stop == last && std::isfinite(value)) return value;
  }
  throw InputError(file, "'" + text + "'", expected);
}

int ParsePixelCount(double value, const std::string& file) {
  if (value >= 0 && value <= 65535 && value == std::floor(value)) return static_cast<int>(value);
  std::ostringstream found;
  found << "an image side of " << value << " px";
  throw InputError(file, found.str(), "a whole number up to 65535");
}

}  // namespace prism
