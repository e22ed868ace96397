// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

namespace prism {

// Decodes an image as 8-bit gray. Throws InputError naming the file if it is missing, does not
// decode or is not width x height.
cv::Mat ReadGrayImage(const std::string& path, int width, int height);

// Decodes a 16-bit one-channel PNG as it is. Errors as above, and for another pixel type.
cv::Mat Read16BitImage(const std::string& path, int width, int height);

// Decodes an image as it is stored (8 or 16 bits, 1 or 3 channels). Errors as above.
cv::Mat ReadImageUnchanged(const std::string& path);

// Writes an image, whole or not at all, in the format of the name's extension. Throws InputError if
// that cannot be done (no such folder, disk full).
void WriteImage(const std::string& path, const cv::Mat& image);

// Throws InputError unless the image has this size.
void RequireImageSize(const std::string& path, const cv::Mat& image, int width, int height);

}  // namespace prism
