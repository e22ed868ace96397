// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace prism {

// A line of a sequence's list file: a time and the words that follow it.
struct TimedLine {
  int64_t time_ns = 0;
  std::vector<std::string> words;
  int line_number = 0;
};

// Reads `time word ...` lines; blank lines and `#` comments are left out. A word with blanks in it
// stands in double quotes, which it need not where only one follows the time. Throws InputError
// (naming file and line) if the file cannot be read, a time is not a finite number, a line does not
// have `num_words` to `max_words` words, or times do not strictly increase.
std::vector<TimedLine> ReadTimeList(const std::string& path, int num_words, int max_words);
inline std::vector<TimedLine> ReadTimeList(const std::string& path, int num_words) {
  return ReadTimeList(path, num_words, num_words);
}

// Seconds as written in files to nanoseconds, rounded. Throws InputError naming `where`.
int64_t ParseTimeNs(const std::string& seconds, const std::string& where);

}  // namespace prism
