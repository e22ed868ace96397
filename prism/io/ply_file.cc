// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/ply_file.h"

#include <cstring>
#include <sstream>

#include "prism/io/atomic_file.h"

namespace prism {

void WritePly(const std::string& path, const std::vector<PlyPoint>& points) {
  std::ostringstream header;
  header << "ply\nformat binary_little_endian 1.0\ncomment PRISM-VO, metres\nelement vertex "
         << points.size()
         << "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
            "property uchar green\nproperty uchar blue\nend_header\n";
  std::string contents = header.str();
  constexpr size_t kBytesPerPoint = 3 * sizeof(float) + 3;
  contents.reserve(contents.size() + kBytesPerPoint * points.size());
  for (const PlyPoint& point : points) {
    char bytes[kBytesPerPoint];
    std::memcpy(bytes, point.position.data(), 3 * sizeof(float));
    std::memcpy(bytes + 3 * sizeof(float), point.rgb.data(), 3);
    contents.append(bytes, kBytesPerPoint);
  }
  WriteTextAtomically(path, contents);
}

}  // namespace prism
