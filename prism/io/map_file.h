// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "prism/camera/projection.h"
#include "prism/scene/place.h"

namespace prism {

// A map kept for later runs: a folder with `images/ID.jpg`, the places' images as they are held,
// and `map.yml`, which OpenCV's FileStorage reads in any language:
//
//   format: "prism_map"   version: 1 (images of virtual points) or 2 (of chief rays)
//   camera: focused_width_px, focused_height_px, focal_length_px, principal_point_x_px, _y_px
//   places: a list of
//     id, time_ns (text), image (relative to the folder),
//     cam_from_world   1 x 7, quaternion x y z w, translation in metres
//     points           N x 4, focused px x y, inverse depth in 1/m, its standard deviation
//     features         M x 3, focused px x y, inverse depth in 1/m or 0
//     descriptors      M x 32, ORB
//
// Writes map.yml last, whole or not at all. Throws InputError if that cannot be done.
void WriteMap(const std::string& folder,
              const PlenopticProjection& camera,
              const std::vector<MappedPlace>& places);

// Throws InputError if the folder holds no such map, or one of another version, or of another
// camera: the focused images must have the same size and show the same (FocusedImage), the focal
// length in px must be the same to 1 %, and the principal point to 1 % of the width.
std::vector<MappedPlace> ReadMap(const std::string& folder, const PlenopticProjection& camera);

}  // namespace prism
