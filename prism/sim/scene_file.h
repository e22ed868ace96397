// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "prism/sim/sim_scene.h"

namespace prism {

// Scene descriptions in YAML; prism/sim/scenes/ holds the built-in ones, which show every key, and
// prism/sim/scenes/README.md lists the kinds of objects.

// Names of the built-in scenes: facade, plane, room.
std::vector<std::string> BuiltInScenes();

// A built-in scene by name, or else a file. Lighting is baked in. Throws InputError naming the file
// for one that cannot be read or parsed, a missing or unknown key or kind, a figure out of its
// range, a texture that is missing and a mesh that does not load (paths are relative to the file).
SimScene ReadScene(const std::string& name_or_path);

// The same in white and without light, which is quick: to check a description.
SimScene ReadSceneShape(const std::string& name_or_path);

}  // namespace prism
