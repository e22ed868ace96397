// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/time_list.h"

#include <cmath>
#include <cstdlib>
#include <iomanip>
#include <sstream>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"

namespace prism {
namespace {

std::string Unquoted(const std::string& text) {
  std::istringstream stream(text);
  std::string word;
  stream >> std::quoted(word);
  return text.front() == '"' ? word : text;
}

}  // namespace

int64_t ParseTimeNs(const std::string& seconds, const std::string& where) {
  char* end = nullptr;
  const long double value = std::strtold(seconds.c_str(), &end);
  if (end != seconds.c_str() + seconds.size() || !std::isfinite(value) || std::abs(value) > 9e9L) {
    throw InputError(where, "'" + seconds + "'", "a time in seconds");
  }
  return std::llround(value * 1e9L);
}

std::vector<TimedLine> ReadTimeList(const std::string& path, int num_words, int max_words) {
  const std::string contents = ReadTextFile(path);
  if (contents.find('\0') != std::string::npos) throw InputError(path, "a binary file", "a list");
  std::istringstream stream(contents);
  std::vector<TimedLine> lines;
  std::string text;
  for (int number = 1; std::getline(stream, text); ++number) {
    std::istringstream line_stream(text.substr(0, text.find('#')));
    std::string time;
    if (!(line_stream >> time)) continue;
    const std::string where = path + ":" + std::to_string(number);
    TimedLine line;
    line.line_number = number;
    line.time_ns = ParseTimeNs(time, where);
    if (max_words == 1) {
      // Paths have blanks in them, and Windows ends lines in two characters.
      std::string rest;
      std::getline(line_stream >> std::ws, rest);
      const size_t end = rest.find_last_not_of(" \t\r");
      if (end != std::string::npos) line.words.push_back(Unquoted(rest.substr(0, end + 1)));
    } else {
      for (std::string word; line_stream >> std::quoted(word);) line.words.push_back(word);
    }
    const int count = static_cast<int>(line.words.size());
    if (count < num_words || count > max_words) {
      throw InputError(where,
                       std::to_string(count) + " words after the time",
                       std::to_string(num_words) +
                           (max_words > num_words ? " to " + std::to_string(max_words) : ""));
    }
    if (!lines.empty() && line.time_ns <= lines.back().time_ns) {
      throw InputError(where, "time " + time, "times that increase from line to line");
    }
    lines.push_back(std::move(line));
  }
  if (lines.empty()) throw InputError(path, "no entries", "a 'time path' line for each frame");
  return lines;
}

}  // namespace prism
