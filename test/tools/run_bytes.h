// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "prism/io/atomic_file.h"

namespace prism {

// What a run of prism_vo wrote and another of the same command has to write again, by the file's
// name: all of it but what the run took and with how many threads.
inline std::map<std::string, std::string> BytesOfRun(const std::string& output_dir) {
  std::map<std::string, std::string> bytes;
  for (const char* name : {"trajectory.txt", "keyframes.txt", "points.ply", "run.json"}) {
    bytes[name] = ReadTextFile(output_dir + "/" + name);
    EXPECT_FALSE(bytes[name].empty()) << output_dir << "/" << name;
  }
  auto run = nlohmann::ordered_json::parse(bytes["run.json"]);
  for (const char* key : {"wall_seconds",
                          "frames_per_second",
                          "processor_seconds",
                          "processor_ms_per_frame",
                          "peak_resident_mib",
                          "stages"}) {
    EXPECT_EQ(run.erase(key), 1u) << key;
  }
  for (const char* key : {"threads", "output_dir"}) EXPECT_EQ(run["options"].erase(key), 1u) << key;
  bytes["run.json"] = run.dump(1);
  return bytes;
}

}  // namespace prism
