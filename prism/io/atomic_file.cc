// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/atomic_file.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

#include "prism/base/error.h"

namespace prism {
namespace fs = std::filesystem;

void WriteFileAtomically(const std::string& path,
                         const std::function<void(const std::string& temporary_path)>& write) {
  const fs::path target(path);
  const fs::path temporary =
      target.parent_path() / (".partial_" + target.stem().string() + target.extension().string());
  std::error_code ignored;
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
  WriteFileAtomically(path, [&](const std::string& temporary_path) {
    std::ofstream stream(temporary_path, std::ios::binary);
    stream << contents;
    stream.close();
    if (!stream) {
      throw InputError(
          path, "an error on writing", "a folder that can be written, with space left");
    }
  });
}

std::string InFolder(const std::string& folder, const std::string& name) {
  return (std::filesystem::path(folder) / name).string();
}

void CreateDirectory(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error || !fs::is_directory(path)) {
    throw InputError(path, error ? error.message() : "a file", "a folder that can be created");
  }
}

std::string ReadTextFile(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream || fs::is_directory(path)) throw InputError(path, "no readable file", "a file");
  std::string text(std::istreambuf_iterator<char>(stream), {});
  constexpr char kByteOrderMark[] = "\xEF\xBB\xBF";  // Windows editors put it there
  if (text.rfind(kByteOrderMark, 0) == 0) text.erase(0, 3);
  return text;
}

}  // namespace prism
