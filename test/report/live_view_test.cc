// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/live_view.h"

#include <chrono>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

namespace prism {
namespace {

constexpr char kAddress[] = "127.0.0.1";

// Starts on a port that is free, which `port` returns.
std::unique_ptr<LiveView> StartSomewhere(int* port) {
  RunReport run;
  run.title = "a run";
  for (*port = 38000; *port < 38100; ++*port) {
    std::string error;
    if (auto live = LiveView::Start(kAddress, *port, run, &error)) return live;
  }
  return nullptr;
}

TEST(LiveView, ServesThePageAndAllEventsToABrowserThatComesLate) {
  int port = 0;
  auto live = StartSomewhere(&port);
  ASSERT_NE(live, nullptr);
  live->Publish({{"number", 1}});
  httplib::Client client(kAddress, port);
  const auto page = client.Get("/");
  ASSERT_TRUE(page);
  EXPECT_THAT(page->body, ::testing::HasSubstr("\"live\":true"));

  std::string stream;
  std::thread reader([&] {
    httplib::Client events(kAddress, port);
    events.Get("/events", [&](const char* data, size_t size) {
      stream.append(data, size);
      return true;
    });
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  live->Publish({{"number", 2}});
  live.reset();
  reader.join();
  EXPECT_THAT(stream, ::testing::HasSubstr("data: {\"number\":1}\n\ndata: {\"number\":2}\n\n"));
}

TEST(LiveView, ABrowserThatGoesAwayDoesNotHoldUpTheRun) {
  int port = 0;
  auto live = StartSomewhere(&port);
  ASSERT_NE(live, nullptr);
  live->Publish({{"number", 0}});
  httplib::Client events(kAddress, port);
  events.Get("/events", [&](const char*, size_t) { return false; });
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < 1000; ++i) live->Publish({{"number", i}});
  live.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

TEST(LiveView, SaysThatAPortIsTaken) {
  int port = 0;
  const auto live = StartSomewhere(&port);
  ASSERT_NE(live, nullptr);
  std::string error;
  EXPECT_EQ(LiveView::Start("256.0.0.1", port, {}, &error), nullptr);
  EXPECT_THAT(error, ::testing::HasSubstr("cannot listen"));
}

}  // namespace
}  // namespace prism
