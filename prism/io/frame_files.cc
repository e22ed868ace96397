// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/frame_files.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <sstream>

#include "prism/base/error.h"
#include "prism/base/format.h"
#include "prism/io/atomic_file.h"
#include "prism/io/time_list.h"
#include "prism/io/video_file.h"

namespace prism {
namespace {

namespace fs = std::filesystem;

constexpr double kAssumedRateHz = 10;

std::string LowerCase(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool IsDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

bool IsFrame(const fs::directory_entry& entry) {
  if (!IsFile(entry.path().string())) return false;
  const std::string extension = LowerCase(entry.path().extension().string());
  const auto& known = {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp"};
  if (std::find(known.begin(), known.end(), extension) == known.end()) return false;
  return LowerCase(entry.path().stem().string()).rfind("white", 0) != 0;
}

// Runs of digits are compared as numbers.
bool ComesBefore(const std::string& left, const std::string& right) {
  size_t i = 0, j = 0;
  while (i < left.size() && j < right.size()) {
    if (!IsDigit(left[i]) || !IsDigit(right[j])) {
      if (left[i] != right[j]) return left[i] < right[j];
      ++i, ++j;
      continue;
    }
    const auto take = [](const std::string& text, size_t* at) {
      while (*at < text.size() && text[*at] == '0') ++*at;
      const size_t start = *at;
      while (*at < text.size() && IsDigit(text[*at])) ++*at;
      return text.substr(start, *at - start);
    };
    const std::string a = take(left, &i), b = take(right, &j);
    if (a.size() != b.size()) return a.size() < b.size();
    if (a != b) return a < b;
  }
  if (left.size() - i != right.size() - j) return left.size() - i < right.size() - j;
  return left < right;  // 007 and 7
}

// The images of a folder in order; names.
std::vector<std::string> ImagesIn(const std::string& folder) {
  std::vector<std::string> names;
  if (!IsFolder(folder)) return names;
  std::error_code ignored;  // a folder that may not be read holds nothing
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (IsFrame(entry)) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end(), ComesBefore);
  return names;
}

// The sub-folder that holds images, "." for the folder itself; empty: none.
std::string FolderOfImages(const std::string& folder) {
  for (const char* name : {"raw", "images", "frames", "data", "."}) {
    if (!ImagesIn(InFolder(folder, name)).empty()) return name;
  }
  return "";
}

std::optional<int64_t> TimeInName(const std::string& name) {
  const std::string stem = fs::path(name).stem().string();
  const size_t point = stem.find('.');
  const bool is_number = !stem.empty() && std::all_of(stem.begin(), stem.end(), [](char c) {
    return IsDigit(c) || c == '.';
  });
  if (!is_number) return std::nullopt;
  if (point != std::string::npos) return ParseTimeNs(stem, name);
  if (stem.size() == 19) return std::strtoll(stem.c_str(), nullptr, 10);
  if (stem.size() == 16) return 1000 * std::strtoll(stem.c_str(), nullptr, 10);
  return std::nullopt;
}

// Of all images in order; empty where not every name holds one, or they do not increase.
std::vector<int64_t> TimesInNames(const std::vector<std::string>& names) {
  std::vector<int64_t> times_ns;
  for (const std::string& name : names) {
    const std::optional<int64_t> time_ns = TimeInName(name);
    if (!time_ns || (!times_ns.empty() && *time_ns <= times_ns.back())) return {};
    times_ns.push_back(*time_ns);
  }
  return times_ns;
}

FrameFiles FromImages(const std::string& folder, const std::string& sub_folder, double rate_hz) {
  const std::vector<std::string> names = ImagesIn(InFolder(folder, sub_folder));
  FrameFiles files;
  std::vector<int64_t> times_ns;
  if (rate_hz == 0) times_ns = TimesInNames(names);
  const double rate = rate_hz > 0 ? rate_hz : kAssumedRateHz;
  files.source = Format("%zu images of %s, ",
                        names.size(),
                        sub_folder == "." ? "the folder" : (sub_folder + "/").c_str());
  if (!times_ns.empty()) {
    files.source += "times in their names";
  } else {
    files.source += Format("in the order of their names, %g Hz", rate);
    if (rate_hz == 0) files.source += " assumed (--rate_hz)";
    for (size_t i = 0; i < names.size(); ++i) {
      times_ns.push_back(std::llround(1e9 * static_cast<double>(i) / rate));
    }
  }
  for (size_t i = 0; i < names.size(); ++i) {
    files.frames.push_back({times_ns[i], (fs::path(folder) / sub_folder / names[i]).string()});
  }
  return files;
}

void RequireFile(const std::string& where, const std::string& name, const std::string& path) {
  if (IsFile(path)) return;
  throw InputError(where, "'" + name + "', which does not exist", "a raw image");
}

// The videos of a folder, or the one that `folder` is.
std::vector<std::string> VideosOf(const std::string& folder) {
  if (IsFile(folder) && IsVideoName(folder)) return {folder};
  std::vector<std::string> paths;
  if (!IsFolder(folder)) return paths;
  std::error_code ignored;  // a folder that may not be read holds nothing
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const std::string path = entry.path().string();
    if (IsVideoName(path) && IsFile(path)) paths.push_back(path);
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

FrameFiles FromVideo(const std::string& path, double rate_hz) {
  const VideoFile video(path);
  const double rate = rate_hz > 0 ? rate_hz : video.rate_hz();
  if (!(rate > 0)) throw InputError(path, "no rate in it", "--rate_hz");
  FrameFiles files;
  for (int i = 0; i < video.size(); ++i) {
    files.frames.push_back({std::llround(1e9 * i / rate), path, i});
  }
  files.source = Format("%d of %s, %g Hz%s",
                        video.size(),
                        fs::path(path).filename().string().c_str(),
                        rate,
                        rate_hz > 0 ? "" : " as it says");
  return files;
}

FrameFiles FromRawList(const std::string& folder, bool skip_missing) {
  const std::string list = InFolder(folder, "raw.txt");
  FrameFiles files;
  for (const TimedLine& line : ReadTimeList(list, 1)) {
    const std::string path = (fs::path(folder) / line.words[0]).string();
    if (!skip_missing)
      RequireFile(list + ":" + std::to_string(line.line_number), line.words[0], path);
    files.frames.push_back({line.time_ns, path});
  }
  files.source = Format("%zu of raw.txt", files.frames.size());
  return files;
}

FrameFiles FromEuroc(const std::string& list, bool skip_missing) {
  FrameFiles files;
  std::istringstream stream(ReadTextFile(list));
  std::string text;
  for (int number = 1; std::getline(stream, text); ++number) {
    while (!text.empty() && (text.back() == '\r' || text.back() == ' ')) text.pop_back();
    if (text.empty() || text[0] == '#') continue;
    const std::string where = list + ":" + std::to_string(number);
    char* end = nullptr;
    const int64_t time_ns = std::strtoll(text.c_str(), &end, 10);
    if (end == text.c_str() || *end != ',') {
      throw InputError(where, "'" + text + "'", "time_ns,name of an image");
    }
    if (!files.frames.empty() && time_ns <= files.frames.back().time_ns) {
      throw InputError(where, "time " + std::to_string(time_ns), "times that increase");
    }
    const std::string name = text.substr(text.find_first_not_of(" ,", end - text.c_str()));
    const std::string path = (fs::path(list).parent_path() / "data" / name).string();
    if (!skip_missing) RequireFile(where, name, path);
    files.frames.push_back({time_ns, path});
  }
  if (files.frames.empty()) throw InputError(list, "no frames", "a line `time_ns,name` a frame");
  files.source = Format("%zu of data.csv", files.frames.size());
  return files;
}

std::string EurocList(const std::string& folder) {
  for (const char* name : {"data.csv", "mav0/cam0/data.csv", "cam0/data.csv"}) {
    std::string path = InFolder(folder, name);
    if (IsFile(path)) return path;
  }
  return "";
}

}  // namespace

FrameFiles FindFrameFiles(const std::string& folder, double rate_hz, bool skip_missing) {
  if (IsFile(InFolder(folder, "raw.txt"))) return FromRawList(folder, skip_missing);
  const std::string euroc = EurocList(folder);
  if (!euroc.empty()) return FromEuroc(euroc, skip_missing);
  const std::string sub_folder = FolderOfImages(folder);
  if (sub_folder.empty()) {
    const std::vector<std::string> videos = VideosOf(folder);
    if (videos.size() > 1) {
      throw InputError(folder, Format("%zu videos", videos.size()), "one, or its own path");
    }
    if (videos.size() == 1) return FromVideo(videos.front(), rate_hz);
    throw InputError(folder, "neither raw.txt, data.csv, images nor a video", "raw frames");
  }
  return FromImages(folder, sub_folder, rate_hz);
}

bool HasUnlistedFrames(const std::string& folder) {
  return !EurocList(folder).empty() || !FolderOfImages(folder).empty() || !VideosOf(folder).empty();
}

std::string FindFile(const std::string& place, const std::string& name) {
  const std::string folder = IsFile(place) ? fs::path(place).parent_path().string() : place;
  std::string exact = InFolder(folder, name);
  if (IsFile(exact)) return exact;
  if (!IsFolder(folder)) return "";
  std::error_code ignored;  // a folder that may not be read holds nothing
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (IsFile(entry.path().string()) &&
        LowerCase(entry.path().filename().string()) == LowerCase(name)) {
      return entry.path().string();
    }
  }
  return "";
}

}  // namespace prism
