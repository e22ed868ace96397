// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace prism {

// The page of prism/report/page with its styles, scripts and libraries put in (generated when the
// project is built, see inline_page.cmake). %REPORT_DATA% stands where the data belong.
extern const char* const kReportPage;

// The same of prism_calibrate, from prism/report/calibration_page.
extern const char* const kCalibrationPage;

// One of these pages with its data. Text that is no UTF-8 is mended.
std::string PageWithData(const char* page, const nlohmann::json& data);

}  // namespace prism
