// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/live_view.h"

#include <chrono>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <nlohmann/json.hpp>

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

RunUpdate UpdateWithFrame(int i) {
  RunUpdate update;
  update.frames.resize(1);
  update.frames[0].time_ns = i * int64_t{1000000000};
  update.frames[0].is_tracked = true;
  return update;
}

RunUpdate UpdateWithKeyframe(int i) {
  RunUpdate update = UpdateWithFrame(i);
  update.keyframes.resize(1);
  update.keyframes[0].index = i;
  update.keyframes[0].keyframe.jpeg = "image";
  update.keyframes[0].keyframe.points.resize(3);
  return update;
}

// A browser's event stream, read until the server ends it.
class EventStream {
 public:
  explicit EventStream(int port, const std::string& last_event_id = "")
      : thread_([this, port, last_event_id] {
          httplib::Client client(kAddress, port);
          httplib::Headers headers;
          if (!last_event_id.empty()) headers.emplace("Last-Event-ID", last_event_id);
          client.Get("/events", headers, [this](const char* data, size_t size) {
            const std::lock_guard<std::mutex> lock(mutex_);
            text_.append(data, size);
            return true;
          });
        }) {}
  ~EventStream() { Finish(); }

  // The whole of it, once the server has ended it.
  std::string Finish() {
    if (thread_.joinable()) thread_.join();
    return text();
  }

  std::string text() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return text_;
  }
  // False if it has not come within ten seconds.
  bool WaitFor(const std::string& part) const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (std::chrono::steady_clock::now() < end) {
      if (text().find(part) != std::string::npos) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }

 private:
  mutable std::mutex mutex_;
  std::string text_;
  std::thread thread_;
};

std::vector<nlohmann::json> EventsOf(const std::string& stream) {
  std::vector<nlohmann::json> events;
  std::istringstream lines(stream);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("data: ", 0) == 0) events.push_back(nlohmann::json::parse(line.substr(6)));
  }
  return events;
}

size_t CountOf(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(LiveView, ServesThePageAndAllEventsToABrowserThatComesLate) {
  int port = 0;
  auto live = StartSomewhere(&port);
  ASSERT_NE(live, nullptr);
  live->Publish(UpdateWithFrame(1));
  httplib::Client client(kAddress, port);
  const auto page = client.Get("/");
  ASSERT_TRUE(page);
  EXPECT_THAT(page->body, ::testing::HasSubstr("\"live\":true"));

  EventStream stream(port);
  ASSERT_TRUE(stream.WaitFor("\"t\":1.0"));
  live->Publish(UpdateWithFrame(2));
  live.reset();
  const auto events = EventsOf(stream.Finish());
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[1]["frames"][0]["t"], 2.0);
}

TEST(LiveView, HoldsTheImagesOfTheLatestKeyframesOnly) {
  int port = 0;
  auto live = StartSomewhere(&port);
  ASSERT_NE(live, nullptr);
  const int count = static_cast<int>(LiveView::kImagesHeld) + 20;
  for (int i = 0; i < count; ++i) live->Publish(UpdateWithKeyframe(i));
  EventStream stream(port);
  live->Publish(UpdateWithFrame(count));
  ASSERT_TRUE(stream.WaitFor("\"t\":" + std::to_string(count) + ".0"));
  live.reset();
  const auto events = EventsOf(stream.Finish());
  ASSERT_EQ(events.size(), static_cast<size_t>(count) + 1) << "every frame, of old keyframes too";
  for (int i = 0; i < count; ++i) {
    const auto& keyframe = events[static_cast<size_t>(i)]["keyframes"][0];
    EXPECT_EQ(keyframe["index"], i);
    EXPECT_TRUE(keyframe.contains("position"));
    EXPECT_EQ(keyframe.contains("jpeg"), i >= 20) << i;
    EXPECT_EQ(keyframe.contains("points"), i >= 20) << i;
  }
}

TEST(LiveView, APageThatWasLoadedBeforeTheEndGetsAllEventsThoughItsStreamOpensLater) {
  int port = 0;
  auto live = StartSomewhere(&port);
  ASSERT_NE(live, nullptr);
  live->Publish(UpdateWithFrame(1));
  ASSERT_TRUE(httplib::Client(kAddress, port).Get("/"));
  std::thread end([&] { live.reset(); });
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  {
    EventStream stream(port);
    EXPECT_TRUE(stream.WaitFor("\"t\":1.0"));
  }
  end.join();
}

TEST(LiveView, ABrokenStreamGoesOnWhereItWas) {
  int port = 0;
  auto live = StartSomewhere(&port);
  ASSERT_NE(live, nullptr);
  for (int i = 1; i <= 3; ++i) live->Publish(UpdateWithFrame(i));
  std::string id;
  {
    std::string text;
    httplib::Client client(kAddress, port);
    client.Get("/events", [&](const char* data, size_t size) {
      text.append(data, size);
      return false;
    });
    const size_t at = text.find("id: ") + 4;
    id = text.substr(at, text.find('\n', at) - at);  // of the first event
  }
  EventStream again(port, id);
  EventStream of_another_run(port, "123.456-1");
  ASSERT_TRUE(again.WaitFor("\"t\":3.0"));
  ASSERT_TRUE(of_another_run.WaitFor("\"reload\":true"));
  live.reset();
  EXPECT_EQ(CountOf(again.Finish(), "\"t\":1.0"), 0u);
  EXPECT_EQ(CountOf(again.Finish(), "\"t\":2.0"), 1u);
}

TEST(LiveView, ABrowserThatGoesAwayDoesNotHoldUpTheRun) {
  int port = 0;
  auto live = StartSomewhere(&port);
  ASSERT_NE(live, nullptr);
  live->Publish(UpdateWithFrame(0));
  httplib::Client events(kAddress, port);
  events.Get("/events", [&](const char*, size_t) { return false; });
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < 1000; ++i) live->Publish(UpdateWithFrame(i));
  live.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

TEST(LiveView, TheEndBringsWhatOnlyAFinishedRunHas) {
  int port = 0;
  auto live = StartSomewhere(&port);
  ASSERT_NE(live, nullptr);
  auto report = std::make_shared<RunReport>();
  report->wall_seconds = 3;
  report->cloud.resize(2);
  RunUpdate end;
  end.finished = report;
  live->Publish(std::move(end));
  EventStream stream(port);
  ASSERT_TRUE(stream.WaitFor("\n\n"));
  live.reset();
  const auto events = EventsOf(stream.Finish());
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0]["finished"]["wall_seconds"], 3);
  EXPECT_TRUE(events[0]["finished"].contains("cloud"));
  EXPECT_FALSE(events[0]["finished"].contains("keyframes"));
}

TEST(LiveView, SaysThatAPortIsTaken) {
  int port = 0;
  const auto live = StartSomewhere(&port);
  ASSERT_NE(live, nullptr);
  std::string error;
  EXPECT_EQ(LiveView::Start(kAddress, port, {}, &error), nullptr);
  EXPECT_THAT(error, ::testing::HasSubstr("cannot listen"));
}

}  // namespace
}  // namespace prism
