// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// What can be wrong with lists, folders and trajectories.
#include <fstream>
#include <sstream>
#include <string>

#include "test/faults/fault.h"

namespace prism {
namespace {

namespace fs = std::filesystem;
using Inject = std::function<void(const std::string&)>;

std::string RgbLine(int frame, const char* folder, double late = 0) {
  char line[64];
  std::snprintf(line, sizeof(line), "%.6f %s/%06d.png\n", 0.1 * frame + late, folder, frame);
  return line;
}

// rgb.txt and depth.txt in place of associations.txt, without a line or with one that is late.
Inject Lists(int no_image, int no_depth, double late = 0) {
  return [=](const std::string& sequence) {
    fs::remove(sequence + "/associations.txt");
    std::string rgb, depth;
    for (int i = 0; i < kFrames; ++i) {
      if (i != no_image) rgb += RgbLine(i, "rgb");
      if (i != no_depth) depth += RgbLine(i, "depth", late);
    }
    WriteFile(sequence + "/rgb.txt", rgb);
    WriteFile(sequence + "/depth.txt", depth);
  };
}

Inject List(const std::string& text) {
  return [=](const std::string& sequence) { WriteFile(sequence + "/associations.txt", text); };
}

Inject File(const std::string& name, const std::string& text) {
  return [=](const std::string& sequence) { WriteFile(sequence + "/" + name, text); };
}

const std::string kPose = " 0 0 0 0 0 0 1\n";

class ListFaults : public testing::TestWithParam<Fault> {};
TEST_P(ListFaults, AreSaid) { ExpectFault(GetParam(), FreshSequence("rgbd")); }

INSTANTIATE_TEST_SUITE_P(
    Rgbd,
    ListFaults,
    testing::Values(
        Fault{"two lists", Lists(-1, -1), "", 0, "12 of 12 frames tracked", 0, 12, 4},
        Fault{"a colour line missing",
              Lists(5, -1),
              "",
              0,
              "depth.txt: 1 images left out, whose nearest colour image",
              0,
              11,
              5},
        Fault{"a depth line missing",
              Lists(-1, 5),
              "",
              0,
              "rgb.txt: 1 images left out, whose nearest depth image",
              0,
              11,
              5},
        Fault{"lists of two recordings", Lists(-1, -1, 97), "", 2, "as are half of all"},
        Fault{"a depth image 97 s from its colour image",
              List("0 rgb/000000.png 0 depth/000000.png\n0.1 rgb/000001.png 97 depth/000001.png\n"),
              "",
              2,
              "associations.txt:2"},
        Fault{"an empty list", List(""), "", 2, "no entries"},
        Fault{"a list of comments", List("# nothing\n"), "", 2, "no entries"},
        Fault{"a word too few", List("0 rgb/000000.png 0\n"), "", 2, "associations.txt:1"},
        Fault{"a time that is none", List("now rgb/a.png 0 depth/a.png\n"), "", 2, "a time in"},
        Fault{"a time of NaN", List("nan rgb/a.png 0 depth/a.png\n"), "", 2, "a time in seconds"},
        Fault{"a time of 1e300", List("1e300 rgb/a.png 0 depth/a.png\n"), "", 2, "a time in"},
        Fault{"times that fall",
              List("1 rgb/000000.png 1 depth/000000.png\n0 rgb/000001.png 0 depth/000001.png\n"),
              "",
              2,
              "increase"},
        Fault{"a name of 5,000 characters",
              List("0 " + std::string(5000, 'n') + " 0 depth/000000.png\n"),
              "",
              2,
              "no such file"},
        Fault{"a name of 10 MB",
              List("0 " + std::string(10 << 20, 'n') + " 0 depth/000000.png\n"),
              "",
              2,
              "no such file"},
        Fault{"a binary list", List(std::string("\0\1\2\xff\n\0", 6)), "", 2, "a binary file"},
        Fault{"a folder as list",
              [](const std::string& s) {
                fs::remove(s + "/associations.txt");
                fs::create_directory(s + "/associations.txt");
              },
              "",
              2,
              "neither raw.txt"},
        Fault{"a loop of links as list",
              [](const std::string& s) {
                fs::remove(s + "/associations.txt");
                fs::create_symlink(s + "/associations.txt", s + "/associations.txt");
              },
              "",
              2,
              "neither raw.txt"},
        Fault{"no calibration",
              [](const std::string& s) { fs::remove(s + "/calibration.txt"); },
              "",
              2,
              "calibration.txt"},
        Fault{"a calibration of words", File("calibration.txt", "a b c"), "", 2, "fx fy cx cy"},
        Fault{"a calibration of NaN",
              File("calibration.txt", "nan nan 160 120 320 240\n"),
              "",
              2,
              "fx fy cx cy"},
        Fault{"a calibration of zeros", File("calibration.txt", "0 0 0 0 0 0\n"), "", 2, "> 0"},
        Fault{"a principal point outside of the image",
              File("calibration.txt", "262.5 262.5 460 120 320 240\n"),
              "",
              2,
              "a principal point cx of 460 px"},
        Fault{"a calibration of another size",
              File("calibration.txt", "262.5 262.5 160 120 640 480\n"),
              "",
              2,
              "7 of 12 frames unreadable"},
        Fault{"ground truth of other times",
              File("groundtruth.txt", "500" + kPose + "501" + kPose),
              "",
              0,
              "no errors, no overlap in time",
              0,
              12},
        Fault{
            "ground truth of words", File("groundtruth.txt", "a b c\n"), "", 2, "groundtruth.txt"},
        Fault{"ground truth of NaN",
              File("groundtruth.txt", "0 nan 0 0 0 0 0 1\n"),
              "",
              2,
              "groundtruth.txt"},
        Fault{"an empty ground truth", File("groundtruth.txt", ""), "", 2, "no pose"}),
    FaultName);

}  // namespace
}  // namespace prism
