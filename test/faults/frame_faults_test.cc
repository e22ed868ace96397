// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// What can happen to frames: a bad one costs a frame, and not the run.
#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "test/faults/fault.h"

namespace prism {
namespace {

namespace fs = std::filesystem;

std::string ImagePath(const std::string& sequence, int frame, const char* folder = "rgb") {
  char name[32];
  std::snprintf(name, sizeof(name), "/%06d.png", frame);
  return sequence + "/" + folder + name;
}

void Truncate(const std::string& path, double share) {
  fs::resize_file(path, static_cast<uintmax_t>(share * static_cast<double>(fs::file_size(path))));
}

using Change = std::function<void(cv::Mat*)>;

// Decodes, changes and encodes images of frames first to last.
std::function<void(const std::string&)> Images(int first,
                                               int last,
                                               const Change& change,
                                               const char* folder = "rgb") {
  return [=](const std::string& sequence) {
    for (int i = first; i <= last; ++i) {
      cv::Mat image = cv::imread(ImagePath(sequence, i, folder), cv::IMREAD_UNCHANGED);
      change(&image);
      cv::imwrite(ImagePath(sequence, i, folder), image);
    }
  };
}

std::function<void(const std::string&)> File(int frame,
                                             const std::function<void(const std::string&)>& change,
                                             const char* folder = "rgb") {
  return [=](const std::string& sequence) { change(ImagePath(sequence, frame, folder)); };
}

// The first part of a JPEG file in place of a PNG: decoders go by what is in it.
void CutJpeg(const std::string& path) {
  std::vector<uint8_t> bytes;
  cv::imencode(".jpg", cv::imread(path, cv::IMREAD_GRAYSCALE), bytes);
  WriteFile(path, std::string(bytes.begin(), bytes.begin() + static_cast<long>(bytes.size() / 2)));
}

// A PNG file that says that it is 2^31 - 1 px wide and high.
void AbsurdHeader(const std::string& path) {
  std::string bytes = ReadTextFile(path);
  bytes.replace(16, 8, "\x7f\xff\xff\xff\x7f\xff\xff\xff");
  WriteFile(path, bytes);
}

const auto kEmpty = [](const std::string& path) { WriteFile(path, ""); };
const auto kText = [](const std::string& path) { WriteFile(path, "not an image\n"); };
const auto kCut = [](const std::string& path) { Truncate(path, 0.5); };
const auto kGone = [](const std::string& path) { fs::remove(path); };
const auto kFolder = [](const std::string& path) {
  fs::remove(path);
  fs::create_directory(path);
};
const auto kLoop = [](const std::string& path) {
  fs::remove(path);
  fs::create_symlink(path, path);
};
const Change kBlack = [](cv::Mat* image) { image->setTo(0); };
const Change kWhite = [](cv::Mat* image) { image->setTo(255); };
const Change kHalf = [](cv::Mat* image) { *image *= 0.5; };
const Change kSmaller = [](cv::Mat* image) { cv::resize(*image, *image, {160, 120}); };
const Change kFourChannels = [](cv::Mat* image) {
  cv::cvtColor(*image, *image, cv::COLOR_GRAY2BGRA);
};
const Change kSixteenBits = [](cv::Mat* image) { image->convertTo(*image, CV_16U, 257); };
const Change kCovered = [](cv::Mat* image) { image->colRange(0, image->cols / 2).setTo(90); };
const Change kPatch = [](cv::Mat* image) {
  cv::randu((*image)(cv::Rect(120, 90, 60, 50)), 0, 255);
};
const Change kSaturated = [](cv::Mat* image) { image->setTo(65535); };

const std::string kUnreadable = "frame 5 unreadable: ";

class FrameFaults : public testing::TestWithParam<Fault> {};
TEST_P(FrameFaults, CostNoMoreThanStated) { ExpectFault(GetParam(), FreshSequence("rgbd")); }

INSTANTIATE_TEST_SUITE_P(
    Rgbd,
    FrameFaults,
    testing::Values(
        Fault{"none", nullptr, "", 0, "12 of 12 frames tracked", 0, 12, 4},
        Fault{"empty image", File(5, kEmpty), "", 0, kUnreadable, 1, 11, 5},
        Fault{"text as image", File(5, kText), "", 0, "does not decode", 1, 11, 5},
        Fault{"cut PNG", File(5, kCut), "", 0, kUnreadable, 1, 11, 5},
        Fault{"cut JPEG", File(5, CutJpeg), "", 0, "without its end", 1, 11, 5},
        Fault{"header of absurd size", File(5, AbsurdHeader), "", 0, kUnreadable, 1, 11, 5},
        Fault{"folder as image", File(5, kFolder), "", 2, "no such file"},
        Fault{"loop of links as image", File(5, kLoop), "", 2, "no such file"},
        Fault{"another size", Images(5, 5, kSmaller), "", 0, "160 x 120 pixels", 1, 11, 5},
        Fault{"missing before the start", File(5, kGone), "", 2, "no such file"},
        Fault{"missing, skipped", File(5, kGone), "--skip_missing", 0, "no such file", 1, 11, 5},
        Fault{"depth missing, skipped",
              File(5, kGone, "depth"),
              "--skip_missing",
              0,
              "no such file",
              1,
              11,
              5},
        Fault{"empty depth", File(5, kEmpty, "depth"), "", 0, kUnreadable, 1, 11, 5},
        Fault{"depth of 8 bits",
              Images(
                  5, 5, [](cv::Mat* m) { m->convertTo(*m, CV_8U); }, "depth"),
              "",
              0,
              "of 8 bits",
              1,
              11,
              5},
        Fault{"depth of 65535 everywhere",
              Images(5, 5, kSaturated, "depth"),
              "",
              0,
              "65535 everywhere",
              1,
              11,
              5},
        Fault{"all depths of 65535",
              Images(0, kFrames - 1, kSaturated, "depth"),
              "",
              2,
              "7 of 12 frames unreadable"},
        Fault{"first frame bad", File(0, kText), "", 0, "frame 0 unreadable", 1, 11, 5},
        Fault{"last frame bad", File(11, kText), "", 0, "frame 11 unreadable", 1, 11, 5},
        Fault{"first ten frames bad",
              [](const std::string& s) {
                for (int i = 0; i < 10; ++i) kText(ImagePath(s, i));
              },
              "",
              2,
              "7 of 12 frames unreadable"},
        Fault{"first ten of many bad",
              [](const std::string& s) {
                for (int i = 0; i < kFrames; ++i) kText(ImagePath(s, i));
              },
              "--ping_pong=3",
              2,
              "the first 10 frames unreadable"},
        Fault{"five of twelve bad",
              [](const std::string& s) {
                for (const int i : {2, 4, 6, 8, 10}) kText(ImagePath(s, i));
              },
              "",
              0,
              "frame 10 unreadable",
              5,
              7,
              8},
        Fault{"four channels", Images(5, 5, kFourChannels), "", 0, "", 0, 12, 4},
        Fault{"16 bits", Images(5, 5, kSixteenBits), "", 0, "", 0, 12, 4},
        Fault{"black frames", Images(5, 6, kBlack), "", 0, "10 of 12", 0, 10, 8},
        Fault{"white frames", Images(5, 6, kWhite), "", 0, "10 of 12", 0, 10, 8},
        Fault{"all black", Images(0, kFrames - 1, kBlack), "", 1, "0 of 12 frames tracked", 0, 0},
        Fault{"blank walls at the end",
              Images(7, 11, kWhite),
              "",
              0,
              "7 of 12 frames tracked",
              0,
              7,
              8},
        Fault{"fewer than half tracked",
              Images(4, 11, kBlack),
              "",
              1,
              "fewer than half of the frames were tracked",
              0,
              4},
        Fault{"exposure halved", Images(6, 11, kHalf), "", 0, "", 0, 12, 8},
        Fault{"half the view covered", Images(5, 8, kCovered), "", 0, "", 0, 10, 20},
        Fault{"a thing that moves", Images(4, 9, kPatch), "", 0, "", 0, 12, 8},
        Fault{"repeated frame",
              [](const std::string& s) {
                fs::copy_file(
                    ImagePath(s, 5), ImagePath(s, 6), fs::copy_options::overwrite_existing);
                fs::copy_file(ImagePath(s, 5, "depth"),
                              ImagePath(s, 6, "depth"),
                              fs::copy_options::overwrite_existing);
              },
              "",
              0,
              "",
              0,
              11,
              15},
        Fault{"wrong depths",
              Images(
                  5, 6, [](cv::Mat* m) { *m *= 2; }, "depth"),
              "",
              0,
              "",
              0,
              10,
              10}),
    FaultName);

void WriteRaw(const std::string& path, const cv::Mat& image) { cv::imwrite(path, image); }

class RawFrameFaults : public testing::TestWithParam<Fault> {};
TEST_P(RawFrameFaults, CostNoMoreThanStated) { ExpectFault(GetParam(), FreshSequence("raw")); }

std::function<void(const std::string&)> RawFile(
    const std::function<void(const std::string&)>& change) {
  return [=](const std::string& sequence) { change(sequence + "/5.png"); };
}

INSTANTIATE_TEST_SUITE_P(
    Raw,
    RawFrameFaults,
    testing::Values(
        Fault{"raw: none", nullptr, "", 0, "", 0, 6},
        Fault{"raw: empty", RawFile(kEmpty), "", 0, kUnreadable, 1, 6},
        Fault{"raw: text", RawFile(kText), "", 0, kUnreadable, 1, 6},
        Fault{"raw: missing", RawFile(kGone), "", 2, "which does not exist"},
        Fault{"raw: missing, skipped", RawFile(kGone), "--skip_missing", 0, kUnreadable, 1, 6},
        Fault{"raw: first frame bad",
              [](const std::string& s) { kText(s + "/0.png"); },
              "",
              0,
              "frame 0 unreadable",
              1,
              6},
        Fault{"raw: another size",
              RawFile([](const std::string& p) {
                WriteRaw(p, cv::Mat(100, 200, CV_8UC1, cv::Scalar(9)));
              }),
              "",
              0,
              "200 x 100 pixels",
              1,
              6},
        Fault{"raw: four channels",
              RawFile([](const std::string& p) {
                WriteRaw(p, cv::Mat(320, 320, CV_8UC4, cv::Scalar(9, 9, 9, 9)));
              }),
              "",
              0,
              "4 channel(s)",
              1,
              6},
        Fault{"raw: 16 bits among 8",
              RawFile([](const std::string& p) {
                WriteRaw(p, cv::Mat(320, 320, CV_16UC1, cv::Scalar(1000)));
              }),
              "",
              0,
              "16 bits a channel",
              1,
              6},
        Fault{"raw: white frame",
              RawFile([](const std::string& p) {
                WriteRaw(p, cv::Mat(320, 320, CV_8UC1, cv::Scalar(255)));
              }),
              "",
              0,
              "",
              0,
              6},
        Fault{"raw: all bad",
              [](const std::string& s) {
                for (int i = 0; i < kFrames; ++i) kText(s + "/" + std::to_string(i) + ".png");
              },
              "",
              2,
              "does not decode"}),
    FaultName);

TEST(LightfieldFrameFaults, AreLeftOut) {
  const std::string sequence = FreshSequence("raw");
  kText(sequence + "/3.png");
  const ProgramResult result =
      RunProgram("prism_lightfield --raw=" + sequence + " --camera=" + sequence +
                 "/camera.yaml --max_frames=5 --threads=1 --output_dir=" + sequence + "_out");
  EXPECT_EQ(result.exit_status, 0) << result.output;
  EXPECT_THAT(result.output, testing::HasSubstr("1 of them could not be read and are left out"));
  EXPECT_THAT(ReadTextFile(sequence + "_out/focused.txt"),
              testing::Not(testing::HasSubstr("\n0.300000000 ")));
}

}  // namespace
}  // namespace prism
