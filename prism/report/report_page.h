// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace prism {

// The page of prism/report/page with its styles, scripts and libraries put in (generated when the
// project is built, see inline_page.cmake). %REPORT_DATA% stands where the data belong.
extern const char* const kReportPage;

}  // namespace prism
