// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

namespace prism {

// Bytes as Base64 text with padding (RFC 4648, Section 4).
std::string Base64(const unsigned char* bytes, size_t count);

}  // namespace prism
