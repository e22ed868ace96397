// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench_suite.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

#include <glog/logging.h>
#include <yaml-cpp/yaml.h>

#include "prism/base/error.h"
#include "prism/base/format.h"
#include "prism/io/atomic_file.h"

namespace prism {
namespace {

size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0]++;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

class SuiteReader {
 public:
  SuiteReader(std::string path, std::string data_dir)
      : path_(std::move(path)), data_dir_(std::move(data_dir)) {}

  BenchSuite Read() const {
    const YAML::Node root = Parse();
    CheckKeys(root,
              {"time_limit_s",
               "memory_limit_mib",
               "repeats",
               "seeds",
               "flags",
               "sequences",
               "variants",
               "external"});
    BenchSuite suite;
    suite.time_limit_s = Number(root, "time_limit_s", suite.time_limit_s, 1e8);
    suite.memory_limit_mib =
        static_cast<int>(Number(root, "memory_limit_mib", suite.memory_limit_mib, 1e9));
    suite.seeds = Seeds(root);
    suite.flags = Flags(root);
    for (const YAML::Node& node : root["sequences"]) {
      CheckKeys(node, {"name", "flagfile", "flags"});
      suite.sequences.push_back(
          {Text(node, "name", true), Text(node, "flagfile", false), Flags(node)});
    }
    for (const YAML::Node& node : root["variants"]) {
      CheckKeys(node, {"name", "flags"});
      suite.variants.push_back({Text(node, "name", true), Flags(node)});
    }
    for (const YAML::Node& node : root["external"]) {
      CheckKeys(node, {"name", "sequence", "trajectory"});
      suite.external.push_back(
          {Text(node, "name", true), Text(node, "sequence", true), Text(node, "trajectory", true)});
    }
    if (suite.sequences.empty()) throw InputError(path_, "no sequence", "a list 'sequences'");
    if (suite.variants.empty()) suite.variants.push_back({"default", {}});
    CheckNames(suite);
    return suite;
  }

 private:
  YAML::Node Parse() const {
    try {
      const YAML::Node root = YAML::Load(ReadTextFile(path_));
      if (!root.IsMap()) throw InputError(path_, "no keys", "a suite (YAML)");
      return root;
    } catch (const YAML::Exception& error) {
      throw InputError(
          path_ + ", line " + std::to_string(error.mark.line + 1), error.msg, "a suite (YAML)");
    }
  }

  std::string At(const YAML::Node& node) const {
    return path_ + ", line " + std::to_string(node.Mark().line + 1);
  }

  void CheckKeys(const YAML::Node& node, const std::vector<std::string>& known) const {
    if (!node.IsMap()) throw InputError(At(node), "no keys", "a map with " + known.front());
    std::set<std::string> seen;
    for (const auto& entry : node) {
      const std::string key = Key(entry.first);
      if (!seen.insert(key).second) {
        throw InputError(At(entry.first), "the key '" + key + "' twice", "each key once");
      }
      if (std::find(known.begin(), known.end(), key) != known.end()) continue;
      throw InputError(At(entry.first),
                       "the unknown key '" + key + "'",
                       "a known one; the nearest is '" + NearestWord(key, known) + "'");
    }
  }

  std::string Key(const YAML::Node& node) const {
    if (!node.IsScalar()) throw InputError(At(node), "a list or map as a key", "a word");
    return node.Scalar();
  }

  std::string Text(const YAML::Node& node, const char* key, bool required) const {
    if (node[key] && node[key].IsScalar()) return Expanded(node[key].as<std::string>());
    if (required || node[key])
      throw InputError(At(node), std::string("no '") + key + "'", "a text");
    return "";
  }

  double Number(const YAML::Node& node, const char* key, double fallback, double max) const {
    if (!node[key]) return fallback;
    double value = 0;
    if (!YAML::convert<double>::decode(node[key], value) || !(value > 0 && value <= max)) {
      throw InputError(At(node[key]),
                       std::string("a bad '") + key + "'",
                       Format("a positive number up to %g", max));
    }
    return value;
  }

  std::vector<int> Seeds(const YAML::Node& root) const {
    std::vector<int> seeds(static_cast<size_t>(Number(root, "repeats", 1, 10000)));
    std::iota(seeds.begin(), seeds.end(), 0);
    const YAML::Node list = root["seeds"];
    if (!list) return seeds;
    if (!list.IsSequence()) throw InputError(At(list), "no seeds", "a list of whole numbers");
    seeds.clear();
    for (const YAML::Node& seed : list) {
      int value = 0;
      if (!seed.IsScalar() || !YAML::convert<int>::decode(seed, value) || value < 0) {
        throw InputError(At(seed), "a bad seed", "whole numbers, 0 or more");
      }
      seeds.push_back(value);
    }
    if (seeds.empty()) throw InputError(At(list), "no seeds", "a list of whole numbers");
    return seeds;
  }

  FlagMap Flags(const YAML::Node& node) const {
    FlagMap flags;
    if (node["flags"] && !node["flags"].IsMap()) {
      throw InputError(At(node["flags"]), "flags that are no map", "flag: value");
    }
    for (const auto& entry : node["flags"]) {
      if (!entry.second.IsScalar()) throw InputError(At(entry.first), "no value", "flag: value");
      flags[Key(entry.first)] = Expanded(entry.second.as<std::string>());
    }
    return flags;
  }

  std::string Expanded(std::string text) const {
    const std::string marker = "{data}";
    const size_t at = text.find(marker);
    return at == std::string::npos ? text : text.replace(at, marker.size(), data_dir_);
  }

  // Names become folders, and tell runs apart.
  void CheckNames(const BenchSuite& suite) const {
    std::set<std::string> seen;
    const auto check = [&](const std::string& name) {
      constexpr size_t kLongestName = 200;  // of a folder: 255
      if (name.empty() || name == "." || name == ".." || name.size() > kLongestName ||
          name.find('/') != std::string::npos || name.find('\0') != std::string::npos) {
        throw InputError(path_, "the name '" + name + "'", "one that can be a folder's");
      }
      if (!seen.insert(name).second) throw InputError(path_, "'" + name + "' twice", "other names");
    };
    for (const BenchSequence& sequence : suite.sequences) check(sequence.name);
    const std::set<std::string> sequences = std::exchange(seen, {});
    for (const BenchVariant& variant : suite.variants) check(variant.name);
    for (const BenchExternal& external : suite.external) {
      if (sequences.count(external.sequence) == 0) {
        throw InputError(path_, "the sequence '" + external.sequence + "'", "a sequence listed");
      }
    }
  }

  const std::string path_;
  const std::string data_dir_;
};

}  // namespace

BenchSuite ReadBenchSuite(const std::string& path, const std::string& data_dir) {
  try {
    return SuiteReader(path, data_dir).Read();
  } catch (const YAML::Exception& error) {  // a map where a list should be, for example
    throw InputError(path, "'" + error.msg + "'", "a suite (YAML)");
  }
}

std::vector<BenchJob> ListJobs(const BenchSuite& suite) {
  std::vector<BenchJob> jobs;
  for (const BenchSequence& sequence : suite.sequences) {
    for (const BenchVariant& variant : suite.variants) {
      for (const int seed : suite.seeds) {
        BenchJob job{sequence.name, variant.name, seed, {}};
        FlagMap flags = suite.flags;
        for (const auto& [name, value] : sequence.flags) flags[name] = value;
        for (const auto& [name, value] : variant.flags) flags[name] = value;
        flags["seed"] = std::to_string(seed);
        if (!sequence.flagfile.empty()) job.arguments.push_back("--flagfile=" + sequence.flagfile);
        for (const auto& [name, value] : flags) job.arguments.push_back("--" + name + "=" + value);
        jobs.push_back(std::move(job));
      }
    }
  }
  return jobs;
}

std::string NearestWord(const std::string& word, const std::vector<std::string>& known) {
  CHECK(!known.empty());
  return *std::min_element(
      known.begin(), known.end(), [&](const std::string& a, const std::string& b) {
        return EditDistance(word, a) < EditDistance(word, b);
      });
}

}  // namespace prism
