// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

namespace prism {

// Bad input from outside: a file, a flag, a calibration. Raised in io, run and tools only; a tool
// prints what() as one line and exits with status 2.
class InputError : public std::runtime_error {
 public:
  // what() reads "FILE: found FOUND, expected EXPECTED".
  InputError(const std::string& file, const std::string& found, const std::string& expected)
      : std::runtime_error(file + ": found " + found + ", expected " + expected) {}
};

// A bad value of an option, by the name of its field. Programs have flags of the same names, and
// print the name as that of a flag.
class OptionError : public InputError {
 public:
  using InputError::InputError;
};

}  // namespace prism
