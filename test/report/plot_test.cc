// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/plot.h"

#include <filesystem>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"

namespace prism {
namespace {

using ::testing::DoubleNear;
using ::testing::HasSubstr;
using ::testing::Pointwise;

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

TEST(Plot, IsWrittenAsSvgAndPngOfTheSameDrawing) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "plot_test";
  CreateDirectory(folder.string());
  Plot plot{"Error <of> A & B", "time (s)", "error (m)", {}, false, true};
  const double gap = std::numeric_limits<double>::quiet_NaN();
  plot.series.push_back({"first", {{0, 0}, {1, 1}, {2, gap}, {3, 1}, {4, 2}}});
  WritePlot((folder / "error").string(), plot);

  const std::string svg = ReadTextFile((folder / "error.svg").string());
  EXPECT_THAT(svg, HasSubstr("Error &lt;of&gt; A &amp; B"));
  EXPECT_EQ(CountOf(svg, "stroke=\"#0072b2\" stroke-width=\"1.5\""), 2u) << "a line on each side";
  const cv::Mat png = cv::imread((folder / "error.png").string());
  ASSERT_EQ(png.size(), cv::Size(1600, 1000));
  const cv::Mat curve_colored = png.reshape(1, static_cast<int>(png.total()));
  int curve_pixels = 0;
  for (int i = 0; i < curve_colored.rows; ++i) {
    const uint8_t* bgr = curve_colored.ptr(i);
    curve_pixels += bgr[0] == 178 && bgr[1] == 114 && bgr[2] == 0;
  }
  EXPECT_GT(curve_pixels, 1000);
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
  const std::string svg = ReadTextFile((folder / "long.svg").string());
  EXPECT_LT(svg.size(), 100000u);
  // The y axis goes from 0 at 445 px to 1.04 x 9 at 40 px.
  EXPECT_THAT(svg, HasSubstr(",55.6 ")) << "the peak";
  std::filesystem::remove_all(folder);
}

TEST(Plot, WithoutPointsShowsEmptyAxes) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "plot_empty_test";
  CreateDirectory(folder.string());
  WritePlot((folder / "empty").string(), {"Nothing", "x", "y", {{"none", {}}}, true, true});
  EXPECT_THAT(ReadTextFile((folder / "empty.svg").string()), HasSubstr("Nothing"));
  std::filesystem::remove_all(folder);
}

TEST(Plot, APageHoldsItsPlotsRowByRow) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "plot_page_test";
  CreateDirectory(folder.string());
  Plot plot{"Bars", "x", "y", {{"median", {{0, 1}, {1, 2}}}}};
  plot.series[0].y_errors = {0.5, std::numeric_limits<double>::quiet_NaN()};
  plot.x_categories = {"near", "far"};
  WritePlotPage((folder / "page").string(), {plot, plot, plot}, 2);
  EXPECT_EQ(cv::imread((folder / "page.png").string()).size(), cv::Size(3200, 2000));
  const std::string svg = ReadTextFile((folder / "page.svg").string());
  EXPECT_EQ(CountOf(svg, ">near</text>"), 3u);
  EXPECT_EQ(CountOf(svg, "stroke=\"#0072b2\" stroke-width=\"1.5\""), 3 * 4u)
      << "a line, a bar and its two caps";
  for (const char* title : {"translate(427.5 24.0)", "translate(1227.5 24.0)"}) {
    EXPECT_EQ(CountOf(svg, title), 1u) << title;
  }
  EXPECT_EQ(CountOf(svg, "translate(427.5 524.0)"), 1u);
  std::filesystem::remove_all(folder);
}

TEST(Plot, AFolderThatIsNotThereIsBadInput) {
  EXPECT_THROW(WritePlot("/nowhere/plot", {}), InputError);
}

}  // namespace
}  // namespace prism
