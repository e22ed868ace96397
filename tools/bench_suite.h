// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

namespace prism {

using FlagMap = std::map<std::string, std::string>;  // flags of prism_vo, without dashes

struct BenchSequence {
  std::string name;
  std::string flagfile;  // empty: none
  FlagMap flags;
};

struct BenchVariant {
  std::string name;
  FlagMap flags;
};

// A trajectory of another system, to stand beside the variants.
struct BenchExternal {
  std::string name;
  std::string sequence;
  std::string trajectory;  // TUM or EuRoC
};

// sequences x variants x seeds. Flags of the suite come first, then those of the sequence, then
// those of the variant; the later one holds.
struct BenchSuite {
  double time_limit_s = 600;
  int memory_limit_mib = 2048;
  std::vector<int> seeds = {0};
  FlagMap flags;
  std::vector<BenchSequence> sequences;
  std::vector<BenchVariant> variants;
  std::vector<BenchExternal> external;
};

struct BenchJob {
  std::string sequence;
  std::string variant;
  int seed = 0;
  std::vector<std::string> arguments;  // of prism_vo, all but --output_dir

  std::string name() const { return sequence + "/" + variant + "/" + std::to_string(seed); }
};

// Reads a suite file (YAML; sequences/SUITES.md says what it may hold). "{data}" in a value becomes
// data_dir; paths are relative to the working directory. Throws InputError, naming the file, for a
// file that cannot be read, a missing or doubled name, and an unknown key, with the nearest known.
BenchSuite ReadBenchSuite(const std::string& path, const std::string& data_dir);

// All runs in a fixed order: job N of --job=N is element N.
std::vector<BenchJob> ListJobs(const BenchSuite& suite);

// The known word with the smallest edit distance to `word`. `known` is not empty.
std::string NearestWord(const std::string& word, const std::vector<std::string>& known);

}  // namespace prism
