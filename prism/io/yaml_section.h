// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <set>
#include <string>
#include <type_traits>

#include <yaml-cpp/yaml.h>
#include <Eigen/Core>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"

namespace prism {

// One map of a YAML file: typed access to its keys, and at the end a check that all were known.
// Everything throws InputError(file, found, expected); `expected` says what a key means.
class YamlSection {
 public:
  // `name` is the path to the map inside the file, empty for the whole of it.
  YamlSection(const std::string& path, const std::string& name, const YAML::Node& node);

  bool Has(const std::string& key);
  YAML::Node Get(const std::string& key, const std::string& expected);

  template <typename T>
  T Value(const std::string& key, const std::string& expected) {
    return As<T>(key, Get(key, expected), expected);
  }

  template <typename T>
  T ValueOr(const std::string& key, T fallback, const std::string& expected) {
    return Has(key) ? Value<T>(key, expected) : fallback;
  }

  // A list of numbers of that length.
  template <int N>
  Eigen::Matrix<double, N, 1> Vector(const std::string& key, const std::string& expected) {
    const YAML::Node node = Get(key, expected);
    if (!node.IsSequence() || node.size() != N) {
      throw InputError(
          path_,
          "'" + prefix_ + key + "' that is no list of " + std::to_string(N) + " numbers",
          expected);
    }
    Eigen::Matrix<double, N, 1> vector;
    for (int i = 0; i < N; ++i) vector[i] = As<double>(key, node[i], expected);
    return vector;
  }

  // [width, height] in whole pixels.
  std::array<int, 2> Size(const std::string& key);

  void RejectUnknownKeys() const;

 private:
  template <typename T>
  T As(const std::string& key, const YAML::Node& node, const std::string& expected) const {
    try {
      T value = node.as<T>();
      if constexpr (std::is_floating_point_v<T>) {
        if (!std::isfinite(value)) throw YAML::BadConversion(node.Mark());
      }
      return value;
    } catch (const YAML::Exception&) {
      const std::string text = node.IsScalar() ? "'" + node.Scalar() + "'" : "a list or map";
      throw InputError(path_, "'" + prefix_ + key + "' of " + text, expected);
    }
  }

  std::string path_;
  std::string prefix_;
  YAML::Node node_;
  std::set<std::string> known_;
};

// Parses `text` and hands its root to `read`; whatever yaml-cpp throws becomes an InputError that
// names `path` and the line.
template <typename Function>
auto ParseYamlText(const std::string& path,
                   const std::string& text,
                   const std::string& expected,
                   Function read) {
  try {
    return read(YAML::Load(text));
  } catch (const YAML::Exception& error) {
    throw InputError(
        path, "'" + error.msg + "' in line " + std::to_string(error.mark.line + 1), expected);
  }
}

template <typename Function>
auto ParseYamlFile(const std::string& path, const std::string& expected, Function read) {
  return ParseYamlText(path, ReadTextFile(path), expected, read);
}

}  // namespace prism
