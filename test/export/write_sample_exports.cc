// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// write_sample_exports FOLDER: a run of exact poses and points in every format.
#include <cstdio>

#include "prism/export/export.h"
#include "test/export/sample_run.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  std::fputs(prism::WriteExports({"colmap", "nerfstudio", "kitti", "euroc", "mcap", "ply", "dense"},
                                 argv[1],
                                 prism::SampleRun())
                 .c_str(),
             stdout);
  return 0;
}
