// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/pybind11.h>

namespace prism {

// Adds `evaluate` to the module.
void BindEvaluation(pybind11::module_* module);

}  // namespace prism
