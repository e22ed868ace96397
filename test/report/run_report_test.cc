// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/run_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/report/base64.h"

namespace prism {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

std::string Base64Of(const std::string& text) {
  return Base64(reinterpret_cast<const unsigned char*>(text.data()), text.size());
}

TEST(Base64, EncodesTheTestVectorsOfRfc4648) {
  EXPECT_EQ(Base64Of(""), "");
  EXPECT_EQ(Base64Of("f"), "Zg==");
  EXPECT_EQ(Base64Of("fo"), "Zm8=");
  EXPECT_EQ(Base64Of("foo"), "Zm9v");
  EXPECT_EQ(Base64Of("foobar"), "Zm9vYmFy");
}

TEST(RunReport, ProblemsNameLostFramesAndSegments) {
  std::vector<ReportFrame> frames(6);
  for (ReportFrame& frame : frames) frame.is_tracked = true;
  EXPECT_TRUE(FindProblems(frames).empty());
  for (int i : {1, 3, 4}) {
    frames[i].is_tracked = false;
    frames[i].status = "lost";
  }
  frames[5].segment = 1;
  EXPECT_THAT(FindProblems(frames),
              ElementsAre("frame 1 not tracked (lost)",
                          "frames 3 to 4 not tracked (lost)",
                          "the trajectory has 2 segments"));
}

TEST(RunReport, ThumbnailIsHalvedUntilItFits) {
  const ImageF image(1300, 600, 100.0f);
  ReportKeyframe keyframe;
  EXPECT_EQ(ThumbnailFactor(1300, 512), 0.25);
  EXPECT_EQ(ThumbnailFactor(512, 512), 1);
  SetThumbnail(image, 512, &keyframe);
  EXPECT_EQ(keyframe.width, 325);
  EXPECT_EQ(keyframe.height, 150);
  EXPECT_EQ(keyframe.jpeg.substr(0, 2), "\xff\xd8");
}

TEST(RunReport, PageIsSelfContainedAndItsDataCannotEndTheScript) {
  RunReport report;
  report.title = "</script><b><!--<script>";
  report.trajectory = {{0, SE3()}};
  const std::string page = FormatReport(report);
  EXPECT_THAT(page, HasSubstr("\\u003c/script>\\u003cb>\\u003c!--\\u003cscript>"));
  for (const char* outside : {"src=\"http", "href=\"http", "sourceMappingURL", "%REPORT_DATA%"}) {
    EXPECT_THAT(page.find(outside), std::string::npos) << outside;
  }
}

}  // namespace
}  // namespace prism
