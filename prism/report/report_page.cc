// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/report_page.h"

#include <glog/logging.h>

namespace prism {

std::string PageWithData(const char* page, const nlohmann::json& data) {
  std::string text = data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  // "</" would end the script element the data stand in, "<!--<script" swallow what follows it.
  for (size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at)) {
    text.replace(at, 1, "\\u003c");
  }
  const std::string marker = "%REPORT_DATA%";
  std::string result = page;
  const size_t at = result.find(marker);
  CHECK_NE(at, std::string::npos) << marker;
  result.replace(at, marker.size(), text);
  return result;
}

}  // namespace prism
