// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/base64.h"

namespace prism {

std::string Base64(const unsigned char* bytes, size_t count) {
  static const char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((count + 2) / 3 * 4);
  for (size_t i = 0; i < count; i += 3) {
    const size_t left = count - i;
    const unsigned block =
        bytes[i] << 16 | (left > 1 ? bytes[i + 1] << 8 : 0) | (left > 2 ? bytes[i + 2] : 0);
    text += kDigits[block >> 18 & 63];
    text += kDigits[block >> 12 & 63];
    text += left > 1 ? kDigits[block >> 6 & 63] : '=';
    text += left > 2 ? kDigits[block & 63] : '=';
  }
  return text;
}

}  // namespace prism
