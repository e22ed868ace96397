// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/io/frame_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/videoio.hpp>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"
#include "prism/io/raw_sequence.h"
#include "prism/io/time_list.h"
#include "test/io/rgbd_folder.h"

namespace prism {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> NamesOf(const FrameFiles& files) {
  std::vector<std::string> names;
  for (const FrameFile& file : files.frames) {
    names.push_back(std::filesystem::path(file.path).filename().string());
  }
  return names;
}

std::vector<int64_t> TimesOf(const FrameFiles& files) {
  std::vector<int64_t> times;
  for (const FrameFile& file : files.frames) times.push_back(file.time_ns);
  return times;
}

std::string ErrorOf(const std::string& folder) {
  try {
    FindFrameFiles(folder, 0);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(FrameFiles, WithoutAListAreInTheOrderOfTheirNumbers) {
  const std::string folder = FreshFolder("a folder");
  for (const char* name :
       {"f10.png", "f9.PNG", "f1.tif", "white.png", "White_2.png", "notes.txt"}) {
    WriteFile(folder + "/" + name, "");
  }
  const FrameFiles files = FindFrameFiles(folder, 20);
  EXPECT_THAT(NamesOf(files), ElementsAre("f1.tif", "f9.PNG", "f10.png"));
  EXPECT_THAT(TimesOf(files), ElementsAre(0, 50000000, 100000000));
  EXPECT_EQ(files.source, "3 images of the folder, in the order of their names, 20 Hz");
  EXPECT_THAT(FindFrameFiles(folder, 0).source, HasSubstr("10 Hz assumed (--rate_hz)"));
  EXPECT_TRUE(HasUnlistedFrames(folder));
}

TEST(FrameFiles, HaveTheTimesOfTheirNames) {
  const std::string seconds = FreshFolder("seconds"), nanoseconds = FreshFolder("nanoseconds");
  std::filesystem::create_directories(nanoseconds + "/images");
  WriteFile(seconds + "/1305031102.175304.png", "");
  WriteFile(seconds + "/1305031102.211214.png", "");
  WriteFile(nanoseconds + "/images/1403636579763555584.bmp", "");
  WriteFile(nanoseconds + "/images/1403636579813555456.bmp", "");
  EXPECT_THAT(TimesOf(FindFrameFiles(seconds, 0)),
              ElementsAre(1305031102175304000, 1305031102211214000));
  EXPECT_THAT(TimesOf(FindFrameFiles(nanoseconds, 0)),
              ElementsAre(1403636579763555584, 1403636579813555456));
  EXPECT_THAT(TimesOf(FindFrameFiles(seconds, 2)), ElementsAre(0, 500000000)) << "as told";
}

// Frame i is of gray value 20 i.
void WriteVideo(const std::string& path, int frames, double rate_hz) {
  cv::VideoWriter writer(path, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), rate_hz, {64, 48});
  ASSERT_TRUE(writer.isOpened()) << path;
  for (int i = 0; i < frames; ++i) writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(20 * i)));
}

TEST(FrameFiles, OfAVideoHaveItsRateOrTheOneTold) {
  const std::string folder = FreshFolder("video");
  WriteVideo(folder + "/a film.avi", 4, 20);
  for (const std::string& sequence : {folder, folder + "/a film.avi"}) {
    EXPECT_TRUE(HasUnlistedFrames(sequence));
    const FrameFiles files = FindFrameFiles(sequence, 0);
    EXPECT_THAT(TimesOf(files), ElementsAre(0, 50000000, 100000000, 150000000));
    EXPECT_EQ(files.source, "4 of a film.avi, 20 Hz as it says");
    EXPECT_EQ(files.frames[3].video_frame, 3);
  }
  EXPECT_THAT(TimesOf(FindFrameFiles(folder, 4)), ElementsAre(0, 250000000, 500000000, 750000000));
  WriteFile(folder + "/Camera.yaml", "");
  EXPECT_EQ(FindFile(folder + "/a film.avi", "camera.yaml"), folder + "/Camera.yaml");
  WriteFile(folder + "/other.mp4", "");
  EXPECT_THAT(ErrorOf(folder), HasSubstr("2 videos"));
}

TEST(FrameFiles, OfAVideoAreReadInAnyOrder) {
  const std::string folder = FreshFolder("video_order");
  WriteVideo(folder + "/film.avi", 12, 10);
  PlenopticCamera camera;
  camera.raw_width = 64;
  camera.raw_height = 48;
  const RawSequence sequence(folder, camera);
  ASSERT_EQ(sequence.size(), 12);
  for (const int i : {0, 2, 1, 3, 11, 8, 4, 5, 0}) {
    EXPECT_NEAR(cv::mean(sequence.Read(i).image)[0], 20 * i, 3) << i;
  }
}

TEST(FrameFiles, AVideoThatDoesNotOpenIsNamed) {
  const std::string folder = FreshFolder("video_broken");
  WriteFile(folder + "/film.mp4", "no video");
  EXPECT_THAT(ErrorOf(folder), AllOf(HasSubstr("film.mp4"), HasSubstr("decoder")));
}

TEST(FrameFiles, OfEurocAreThoseOfItsList) {
  const std::string folder = FreshFolder("euroc");
  std::filesystem::create_directories(folder + "/mav0/cam0/data");
  WriteFile(folder + "/mav0/cam0/data/b.png", "");
  const std::string list = folder + "/mav0/cam0/data.csv";
  WriteFile(list, "#timestamp [ns],filename\r\n1403636579763555584,b.png\r\n");
  EXPECT_THAT(TimesOf(FindFrameFiles(folder, 0)), ElementsAre(1403636579763555584));
  EXPECT_THAT(NamesOf(FindFrameFiles(folder, 0)), ElementsAre("b.png"));
  WriteFile(list, "5,missing.png\n");
  EXPECT_THAT(ErrorOf(folder), HasSubstr("data.csv:1: found 'missing.png', which does not exist"));
  WriteFile(list, "soon,b.png\n");
  EXPECT_THAT(ErrorOf(folder), HasSubstr("data.csv:1: found 'soon,b.png'"));
}

TEST(FrameFiles, OfWindowsListsMayHaveBlanksInTheirPaths) {
  const std::string folder = FreshFolder("windows");
  std::filesystem::create_directories(folder + "/my frames");
  WriteFile(folder + "/my frames/first one.png", "");
  WriteFile(folder + "/raw.txt",
            "\xEF\xBB\xBF"
            "1.5 my frames/first one.png\r\n\r\n# end\r\n");
  const FrameFiles files = FindFrameFiles(folder, 0);
  EXPECT_THAT(NamesOf(files), ElementsAre("first one.png"));
  EXPECT_THAT(TimesOf(files), ElementsAre(1500000000));
  WriteFile(folder + "/list.txt", "1 \"a b.png\" c.png\r\n");
  EXPECT_THAT(ReadTimeList(folder + "/list.txt", 2).front().words, ElementsAre("a b.png", "c.png"));
}

TEST(FrameFiles, AFolderWithoutFramesIsBadInput) {
  const std::string folder = FreshFolder("empty");
  EXPECT_THAT(ErrorOf(folder), HasSubstr("found neither raw.txt, data.csv, images nor a video"));
  EXPECT_FALSE(HasUnlistedFrames(folder));
}

TEST(Files, AreFoundWhateverTheCase) {
  const std::string folder = FreshFolder("case");
  WriteFile(folder + "/MLA_calibration.XML", "");
  EXPECT_EQ(FindFile(folder, "MLA_Calibration.xml"), folder + "/MLA_calibration.XML");
  EXPECT_EQ(FindFile(folder, "camera.yaml"), "");
}

}  // namespace
}  // namespace prism
