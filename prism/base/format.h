// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <string>

namespace prism {

// printf into a string; cut after 299 characters.
template <typename... Values>
std::string Format(const char* format, Values... values) {
  char text[300];
  std::snprintf(text, sizeof(text), format, values...);
  return text;
}

}  // namespace prism
