// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/atomic_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

#include "prism/base/error.h"

namespace prism {
namespace fs = std::filesystem;

namespace {

// Where a link leads in the end; the path itself if it is none.
fs::path BehindLinks(const fs::path& path) {
  constexpr int kMaxLinks = 40;  // as the kernel allows
  std::error_code error;
  fs::path target = path;
  for (int i = 0; fs::is_symlink(target, error); ++i) {
    const fs::path link = fs::read_symlink(target, error);
    if (error || i == kMaxLinks) throw InputError(path.string(), "a loop of links", "a file");
    target = target.parent_path() / link;  // an absolute link replaces all before it
  }
  return target;
}

std::string LastError() { return errno != 0 ? std::strerror(errno) : "an error on writing"; }

}  // namespace

void WriteFileAtomically(const std::string& path,
                         const std::function<void(const std::string& temporary_path)>& write) {
  std::error_code ignored;
  const fs::path target = BehindLinks(path);
  const fs::file_status there = fs::status(target, ignored);
  if (fs::exists(there) && !fs::is_regular_file(there)) {
    if (fs::is_directory(there)) throw InputError(path, "a folder", "a file that can be written");
    write(target.string());  // a device or pipe: it is no file that could be replaced
    return;
  }
  const fs::path temporary =
      target.parent_path() / (".partial_" + target.stem().string() + target.extension().string());
  try {
    write(temporary.string());
    fs::rename(temporary, target);
  } catch (const fs::filesystem_error& error) {
    fs::remove(temporary, ignored);
    throw InputError(path, error.code().message(), "a file that can be written");
  } catch (...) {
    fs::remove(temporary, ignored);
    throw;
  }
}

void WriteTextAtomically(const std::string& path, const std::string& contents) {
  WriteStreamAtomically(path, [&](std::ostream& stream) { stream << contents; });
}

void WriteStreamAtomically(const std::string& path,
                           const std::function<void(std::ostream&)>& write) {
  WriteFileAtomically(path, [&](const std::string& temporary_path) {
    errno = 0;
    std::ofstream stream(temporary_path, std::ios::binary);
    write(stream);
    stream.close();
    if (!stream) {
      throw InputError(
          path, "'" + LastError() + "'", "a folder that can be written, with space left");
    }
  });
}

std::string InFolder(const std::string& folder, const std::string& name) {
  return (std::filesystem::path(folder) / name).string();
}

void CreateDirectory(const std::string& path) {
  std::error_code error, ignored;
  fs::create_directories(path, error);
  if (error || !fs::is_directory(path, ignored)) {
    throw InputError(path, error ? error.message() : "a file", "a folder that can be created");
  }
}

void RequireWritableFolder(const std::string& path) {
  CreateDirectory(path);
  const std::string probe = InFolder(path, ".probe");
  WriteTextAtomically(probe, "can be written\n");
  std::error_code ignored;
  fs::remove(probe, ignored);
}

bool IsFile(const std::string& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

bool IsFolder(const std::string& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

std::string ReadTextFile(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream || IsFolder(path)) throw InputError(path, "no readable file", "a file");
  std::string text(std::istreambuf_iterator<char>(stream), {});
  constexpr char kByteOrderMark[] = "\xEF\xBB\xBF";  // Windows editors put it there
  if (text.rfind(kByteOrderMark, 0) == 0) text.erase(0, 3);
  return text;
}

}  // namespace prism
