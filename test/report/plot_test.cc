// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/plot.h"

#include <filesystem>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <pugixml.hpp>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"

namespace prism {
namespace {

using ::testing::AllOf;
using ::testing::DoubleNear;
using ::testing::HasSubstr;
using ::testing::Pointwise;
using ::testing::StartsWith;

size_t CountOf(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(Plot, TicksAreRoundNumbersInsideTheAxis) {
  EXPECT_THAT(AxisTicks(0, 10, 5), Pointwise(DoubleNear(1e-12), {0, 2, 4, 6, 8, 10}));
  EXPECT_THAT(AxisTicks(-0.13, 0.26, 4), Pointwise(DoubleNear(1e-12), {-0.1, 0.0, 0.1, 0.2}));
  EXPECT_THAT(AxisTicks(994, 1003, 4), Pointwise(DoubleNear(1e-9), {995, 1000}));
}

// Of the first series, in an SVG.
const char* const kFirstColor = "stroke:rgb(0%,44.705882%,69.803922%)";

bool IsFirstColor(const cv::Vec3b& bgr) { return bgr == cv::Vec3b(178, 114, 0); }

int CountFirstColor(const cv::Mat& png) {
  int count = 0;
  for (int y = 0; y < png.rows; ++y) {
    for (int x = 0; x < png.cols; ++x) count += IsFirstColor(png.at<cv::Vec3b>(y, x));
  }
  return count;
}

// Pixels that are no background in a part of the picture.
int InkIn(const cv::Mat& png, const cv::Rect& part) {
  cv::Mat gray;
  cv::cvtColor(png(part), gray, cv::COLOR_BGR2GRAY);
  return cv::countNonZero(gray < 128);
}

// Strokes of the first series' colour and this width. A document that is no
// XML has none, and is a failure.
size_t StrokesOfFirst(const std::string& svg, const std::string& width) {
  pugi::xml_document document;
  const pugi::xml_parse_result result = document.load_string(svg.c_str());
  EXPECT_TRUE(result) << result.description();
  size_t count = 0;
  for (const auto& node : document.select_nodes("//path[@style]")) {
    const std::string style = node.node().attribute("style").value();
    count += CountOf(style, kFirstColor) > 0 && CountOf(style, "stroke-width:" + width + ";") > 0;
  }
  return count;
}

TEST(Plot, IsWrittenAsPdfSvgAndPngOfTheSameDrawing) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "plot_test";
  CreateDirectory(folder.string());
  Plot plot{"Error <of> A & B", "time (s)", "error (m)", {}, false, true};
  const double gap = std::numeric_limits<double>::quiet_NaN();
  plot.series.push_back({"first", {{0, 0}, {1, 1}, {2, gap}, {3, 1}, {4, 2}}});
  WritePlot((folder / "error").string(), plot);

  EXPECT_EQ(StrokesOfFirst(ReadTextFile((folder / "error.svg").string()), "1.5"), 2u)
      << "a line on each side of the gap";
  pugi::xml_document document;
  ASSERT_TRUE(document.load_file((folder / "error.svg").c_str()));
  EXPECT_THAT(document.child("svg").child_value("desc"),
              AllOf(HasSubstr("Error <of> A & B\n"), HasSubstr("first\n")));
  const cv::Mat png = cv::imread((folder / "error.png").string());
  ASSERT_EQ(png.size(), cv::Size(1600, 1000));
  EXPECT_GT(CountFirstColor(png), 1000);
  EXPECT_GT(InkIn(png, {400, 20, 800, 50}), 200) << "the title";
  EXPECT_GT(InkIn(png, {20, 200, 40, 600}), 100) << "the label of the y axis, upwards";
  const std::string pdf = ReadTextFile((folder / "error.pdf").string());
  EXPECT_THAT(pdf, StartsWith("%PDF-"));
  EXPECT_THAT(pdf, HasSubstr("/MediaBox [ 0 0 800 500 ]"));
  EXPECT_THAT(pdf, HasSubstr("/FontFile")) << "its fonts are inside";
  EXPECT_THAT(pdf, HasSubstr("/ToUnicode")) << "text can be copied and searched";
  std::filesystem::remove_all(folder);
}

TEST(Plot, ALongLineKeepsItsPeaksAndFewPoints) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "plot_long_test";
  CreateDirectory(folder.string());
  Plot plot{"Long", "x", "y", {{"noise", {}}}, false, true};
  for (int i = 0; i < 200000; ++i) {
    plot.series[0].points.push_back({static_cast<double>(i), i % 2 == 0 ? 1.0 : 2.0});
  }
  plot.series[0].points[123457].y = 9;
  WritePlot((folder / "long").string(), plot);
  EXPECT_LT(std::filesystem::file_size(folder / "long.svg"), 200000u);
  // The y axis goes from 0 at 445 px to 1.04 x 9 at 40 px.
  const cv::Mat png = cv::imread((folder / "long.png").string());
  EXPECT_GT(CountFirstColor(png(cv::Rect(0, 2 * 56, 1600, 20))), 10) << "the peak";
  EXPECT_EQ(CountFirstColor(png(cv::Rect(0, 0, 1300, 2 * 54))), 0) << "nothing above it";
  std::filesystem::remove_all(folder);
}

TEST(Plot, WithoutPointsShowsEmptyAxes) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "plot_empty_test";
  CreateDirectory(folder.string());
  WritePlot((folder / "empty").string(), {"Nothing", "x", "y", {{"none", {}}}, true, true});
  const cv::Mat png = cv::imread((folder / "empty.png").string());
  EXPECT_EQ(CountFirstColor(png(cv::Rect(0, 200, 1600, 800))), 0) << "no line";
  EXPECT_GT(InkIn(png, {400, 20, 800, 50}), 100) << "the title";
  std::filesystem::remove_all(folder);
}

TEST(Plot, APageHoldsItsPlotsRowByRow) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "plot_page_test";
  CreateDirectory(folder.string());
  Plot plot{"Bars", "x", "y", {{"median", {{0, 1}, {1, 2}}}}};
  plot.series[0].y_errors = {0.5, std::numeric_limits<double>::quiet_NaN()};
  plot.x_categories = {"near", "far"};
  WritePlotPage((folder / "page").string(), {plot, plot, plot}, 2);
  const cv::Mat png = cv::imread((folder / "page.png").string());
  ASSERT_EQ(png.size(), cv::Size(3200, 2000));
  EXPECT_EQ(StrokesOfFirst(ReadTextFile((folder / "page.svg").string()), "1.5"), 3 * 4u)
      << "a line, a bar and its two caps";
  const std::string pdf = ReadTextFile((folder / "page.pdf").string());
  EXPECT_THAT(pdf, HasSubstr("/MediaBox [ 0 0 1600 1000 ]"));
  // Titles of the three, and nothing where a fourth would be.
  const cv::Rect title(700, 20, 300, 50);
  EXPECT_GT(InkIn(png, title), 50);
  EXPECT_GT(InkIn(png, title + cv::Point(1600, 0)), 50);
  EXPECT_GT(InkIn(png, title + cv::Point(0, 1000)), 50);
  EXPECT_EQ(InkIn(png, {1600, 1000, 1600, 1000}), 0);
  std::filesystem::remove_all(folder);
}

TEST(Plot, AFolderThatIsNotThereIsBadInput) {
  EXPECT_THROW(WritePlot("/nowhere/plot", {}), InputError);
}

}  // namespace
}  // namespace prism
