// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/atomic_file.h"

#include <sys/stat.h>

#include <filesystem>
#include <functional>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/base/error.h"
#include "test/io/rgbd_folder.h"

namespace prism {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string ErrorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(AtomicFile, DevicesAreWrittenToAndNotReplaced) {
  EXPECT_THAT(ErrorOf([] { WriteTextAtomically("/dev/full", std::string(10000, 'x')); }),
              HasSubstr("/dev/full: found 'No space left on device'"));
  EXPECT_EQ(fs::status("/dev/full").type(), fs::file_type::character);
  EXPECT_EQ(ErrorOf([] { WriteTextAtomically("/dev/null", "x"); }), "");
  EXPECT_EQ(fs::status("/dev/null").type(), fs::file_type::character);
}

TEST(AtomicFile, PipesAreWrittenTo) {
  const std::string pipe = FreshFolder("atomic") + "/pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::string got;
  std::thread reader([&] { got = ReadTextFile(pipe); });
  WriteTextAtomically(pipe, "through");
  reader.join();
  EXPECT_EQ(got, "through");
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST(AtomicFile, LinksStayAndWhatTheyLeadToIsWritten) {
  const std::string folder = FreshFolder("atomic");
  fs::create_directory(folder + "/there");
  WriteFile(folder + "/there/file", "old");
  fs::create_symlink("there/file", folder + "/link");
  fs::create_symlink(folder + "/link", folder + "/link_to_link");
  fs::create_symlink("there/new", folder + "/dangling");
  WriteTextAtomically(folder + "/link_to_link", "new");
  EXPECT_EQ(ReadTextFile(folder + "/there/file"), "new");
  WriteTextAtomically(folder + "/dangling", "made");
  EXPECT_EQ(ReadTextFile(folder + "/there/new"), "made");
  for (const char* link : {"/link", "/link_to_link", "/dangling"}) {
    EXPECT_TRUE(fs::is_symlink(folder + link)) << link;
  }
}

TEST(AtomicFile, WhatCannotBeWrittenIsNamedAndLeavesNothing) {
  const std::string folder = FreshFolder("atomic");
  fs::create_symlink(folder + "/loop", folder + "/loop");
  EXPECT_THAT(ErrorOf([&] { WriteTextAtomically(folder, "x"); }), HasSubstr("found a folder"));
  EXPECT_THAT(ErrorOf([&] { WriteTextAtomically(folder + "/no/file", "x"); }),
              HasSubstr("No such file or directory"));
  EXPECT_THAT(ErrorOf([&] { WriteTextAtomically(folder + "/loop", "x"); }), HasSubstr("/loop"));
  EXPECT_THAT(ErrorOf([&] { WriteTextAtomically(folder + "/" + std::string(300, 'n'), "x"); }),
              HasSubstr("File name too long"));
  EXPECT_THAT(ErrorOf([&] { RequireWritableFolder("/proc/nowhere"); }), HasSubstr("/proc"));
  EXPECT_THAT(ErrorOf([&] { RequireWritableFolder("/sys"); }), HasSubstr("/sys"));
  RequireWritableFolder(folder);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
}

TEST(AtomicFile, WhatCannotBeLookedAtIsNoFileAndNoFolder) {
  const std::string folder = FreshFolder("atomic");
  fs::create_symlink(folder + "/loop", folder + "/loop");
  for (const std::string& path : {folder + "/loop", folder + "/" + std::string(5000, 'n')}) {
    EXPECT_FALSE(IsFile(path));
    EXPECT_FALSE(IsFolder(path));
    EXPECT_THAT(ErrorOf([&] { ReadTextFile(path); }), HasSubstr("no readable file"));
  }
}

}  // namespace
}  // namespace prism
