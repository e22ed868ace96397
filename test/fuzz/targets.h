// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

namespace prism {

// A reader that is fed with anything. It may throw InputError; every other end is a bug.
using FuzzTarget = void (*)(const std::string& bytes);

// By the name of their folder in seeds/.
const std::map<std::string, FuzzTarget>& FuzzTargets();

}  // namespace prism
