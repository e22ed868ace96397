// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

namespace prism {

// Bad input from outside: a file, a flag, a calibration. Raised in io and in tools only; a tool
// prints what() as one line and exits with status 2.
class InputError : public std::runtime_error {
 public:
  // what() reads "FILE: found FOUND, expected EXPECTED".
  InputError(const std::string& file, const std::string& found, const std::string& expected)
      : std::runtime_error(file + ": found " + found + ", expected " + expected) {}
};

}  // namespace prism
