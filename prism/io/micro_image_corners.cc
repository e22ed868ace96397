// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/micro_image_corners.h"

#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>
#include <utility>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"

namespace prism {
namespace {

std::vector<std::string> SplitLine(std::string line) {
  std::vector<std::string> fields;
  while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) {
    const size_t first = field.find_first_not_of(" \t\"");
    const size_t last = field.find_last_not_of(" \t\"");
    fields.push_back(first == std::string::npos ? "" : field.substr(first, last - first + 1));
  }
  return fields;
}

// The numbers of some columns, line by line.
class Table {
 public:
  // `names`: for each column wanted the names it may have.
  Table(const std::string& path, const std::vector<std::vector<std::string>>& names) : path_(path) {
    std::istringstream text(ReadTextFile(path));
    std::string line;
    std::getline(text, line);
    if (line.rfind("\xEF\xBB\xBF", 0) == 0) line.erase(0, 3);
    const std::vector<std::string> header = SplitLine(line);
    std::vector<size_t> columns;
    for (const auto& alternatives : names) columns.push_back(Find(header, alternatives));
    int number = 1;
    while (std::getline(text, line)) {
      ++number;
      const std::vector<std::string> fields = SplitLine(line);
      if (fields.empty() || fields[0].rfind('#', 0) == 0) continue;
      std::vector<double> row;
      for (const size_t column : columns) {
        row.push_back(Number(column < fields.size() ? fields[column] : "", number));
      }
      rows.emplace_back(number, row);
    }
    if (rows.empty()) throw InputError(path, "no lines", "a header and a line each");
  }

  std::vector<std::pair<int, std::vector<double>>> rows;  // with the number of the line

 private:
  size_t Find(const std::vector<std::string>& header,
              const std::vector<std::string>& alternatives) const {
    for (size_t i = 0; i < header.size(); ++i) {
      for (const std::string& name : alternatives) {
        if (header[i] == name) return i;
      }
    }
    throw InputError(path_, "no column '" + alternatives[0] + "'", "it in the first line");
  }

  double Number(const std::string& text, int line) const {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (text.empty() || *end != '\0' || !std::isfinite(value)) {
      throw InputError(path_, "'" + text + "' in line " + std::to_string(line), "a number");
    }
    return value;
  }

  std::string path_;
};

using LensKey = std::pair<int, int>;

int WholeNumber(const std::string& path, int line, double value) {
  if (std::abs(value) <= 1e9 && std::abs(value - std::round(value)) < 1e-3) {
    return static_cast<int>(std::lround(value));
  }
  std::ostringstream found;
  found << "'" << value << "' in line " << line;
  throw InputError(path, found.str(), "a whole number, at most 10^9");
}

LensKey KeyOf(const std::string& path, int line, const std::vector<double>& row) {
  return {WholeNumber(path, line, row[0]), WholeNumber(path, line, row[1])};
}

// The distance from the first centre to the one nearest to it: what a corner may be away.
double PitchOf(const std::map<LensKey, Eigen::Vector2d>& centers) {
  double pitch = INFINITY;
  for (const auto& [key, center] : centers) {
    if (key != centers.begin()->first) {
      pitch = std::min(pitch, (center - centers.begin()->second).norm());
    }
  }
  return pitch;
}

}  // namespace

std::vector<MicroImageCorner> ReadMicroImageCorners(const std::string& corners_path,
                                                    const std::string& centers_path) {
  const Table center_table(centers_path, {{"k"}, {"l"}, {"u", "x"}, {"v", "y"}});
  std::map<LensKey, Eigen::Vector2d> centers;
  for (const auto& [line, row] : center_table.rows) {
    if (!centers.emplace(KeyOf(centers_path, line, row), Eigen::Vector2d(row[2], row[3])).second) {
      throw InputError(centers_path,
                       "a micro image twice, line " + std::to_string(line),
                       "one centre for each k, l");
    }
  }
  if (centers.size() < 2) throw InputError(centers_path, "one micro image", "two or more");
  const double pitch = PitchOf(centers);
  const Table corner_table(corners_path, {{"k"}, {"l"}, {"u"}, {"v"}, {"cluster"}, {"frame"}});
  std::vector<MicroImageCorner> corners;
  for (const auto& [line, row] : corner_table.rows) {
    const auto center = centers.find(KeyOf(corners_path, line, row));
    if (center == centers.end()) {
      throw InputError(corners_path,
                       "a micro image without centre in line " + std::to_string(line),
                       "one of " + centers_path);
    }
    MicroImageCorner corner;
    corner.px = {row[2], row[3]};
    corner.micro_image_px = center->second;
    corner.cluster = WholeNumber(corners_path, line, row[4]);
    corner.frame = WholeNumber(corners_path, line, row[5]);
    if (!((corner.px - corner.micro_image_px).norm() <= pitch)) {
      throw InputError(corners_path,
                       "a corner outside its micro image in line " + std::to_string(line),
                       "raw px in the image of " + centers_path);
    }
    corners.push_back(corner);
  }
  return corners;
}

}  // namespace prism
