// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/ply_file.h"

#include <cstring>
#include <ostream>

#include "prism/io/atomic_file.h"

namespace prism {

void WritePly(const std::string& path, const std::vector<PlyPoint>& points) {
  WriteStreamAtomically(path, [&](std::ostream& stream) {
    stream << "ply\nformat binary_little_endian 1.0\ncomment PRISM-VO, metres\nelement vertex "
           << points.size()
           << "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
              "property uchar green\nproperty uchar blue\nend_header\n";
    constexpr size_t kBytesPerPoint = 3 * sizeof(float) + 3;
    for (const PlyPoint& point : points) {
      char bytes[kBytesPerPoint];
      std::memcpy(bytes, point.position.data(), 3 * sizeof(float));
      std::memcpy(bytes + 3 * sizeof(float), point.rgb.data(), 3);
      stream.write(bytes, kBytesPerPoint);
    }
  });
}

}  // namespace prism
