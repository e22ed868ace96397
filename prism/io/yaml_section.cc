// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/yaml_section.h"

#include "prism/io/camera_number.h"

namespace prism {

YamlSection::YamlSection(const std::string& path, const std::string& name, const YAML::Node& node)
    : path_(path), prefix_(name.empty() ? "" : name + "."), node_(node) {
  if (!node.IsMap()) {
    throw InputError(path, name.empty() ? "no map" : "'" + name + "' that is no map", "keys");
  }
  std::set<std::string> seen;
  for (const auto& entry : node) {
    const auto key = entry.first.as<std::string>();
    if (!seen.insert(key).second) {
      throw InputError(path, "the key '" + prefix_ + key + "' twice", "each key once");
    }
  }
}

bool YamlSection::Has(const std::string& key) {
  known_.insert(key);
  return node_[key].IsDefined();
}

YAML::Node YamlSection::Get(const std::string& key, const std::string& expected) {
  if (!Has(key)) throw InputError(path_, "no key '" + prefix_ + key + "'", expected);
  return node_[key];
}

std::array<int, 2> YamlSection::Size(const std::string& key) {
  const Eigen::Vector2d size = Vector<2>(key, "[width, height] in px");
  return {ParsePixelCount(size.x(), path_), ParsePixelCount(size.y(), path_)};
}

void YamlSection::RejectUnknownKeys() const {
  for (const auto& entry : node_) {
    const auto key = entry.first.as<std::string>();
    if (known_.count(key) > 0) continue;
    std::string expected = "one of";
    for (const std::string& name : known_) expected += " " + prefix_ + name;
    throw InputError(path_, "the unknown key '" + prefix_ + key + "'", expected);
  }
}

}  // namespace prism
