// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/live_view.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <httplib.h>

namespace prism {
namespace {

// How often a stream without news is written to, to notice that the browser has gone.
constexpr auto kHeartbeat = std::chrono::seconds(1);
constexpr auto kPatience = std::chrono::seconds(2);

}  // namespace

struct LiveView::Server {
  struct Browser {
    size_t events_got = 0;
    bool gone = false;
  };

  httplib::Server http;
  std::thread thread;
  std::string page;

  std::mutex mutex;  // guards what follows
  std::condition_variable changed;
  std::vector<std::string> events;
  std::vector<std::shared_ptr<Browser>> browsers;
  bool stopping = false;

  // Writes what a browser has not got yet; false ends its stream.
  bool Serve(Browser* browser, httplib::DataSink* sink) {
    std::string text;
    size_t end = 0;
    {
      std::unique_lock<std::mutex> lock(mutex);
      changed.wait_for(
          lock, kHeartbeat, [&] { return stopping || browser->events_got < events.size(); });
      end = events.size();
      for (size_t i = browser->events_got; i < end; ++i) text += "data: " + events[i] + "\n\n";
      if (stopping && text.empty()) {
        sink->done();
        return true;
      }
    }
    if (text.empty()) text = ": still here\n\n";
    const bool written = sink->write(text.data(), text.size());
    const std::lock_guard<std::mutex> lock(mutex);
    browser->events_got = end;
    browser->gone = !written;
    changed.notify_all();
    return written;
  }

  bool AllServed() const {
    return std::all_of(browsers.begin(), browsers.end(), [&](const auto& browser) {
      return browser->gone || browser->events_got == events.size();
    });
  }
};

std::unique_ptr<LiveView> LiveView::Start(const std::string& address,
                                          int port,
                                          const RunReport& run,
                                          std::string* error) {
  auto server = std::make_unique<Server>();
  Server* const s = server.get();
  s->page = FormatReport(run, true);
  s->http.Get("/", [s](const httplib::Request&, httplib::Response& response) {
    response.set_content(s->page, "text/html; charset=utf-8");
  });
  s->http.Get("/events", [s](const httplib::Request&, httplib::Response& response) {
    response.set_header("Cache-Control", "no-store");
    const auto browser = std::make_shared<Server::Browser>();
    {
      const std::lock_guard<std::mutex> lock(s->mutex);
      s->browsers.push_back(browser);
    }
    response.set_chunked_content_provider(
        "text/event-stream",
        [s, browser](size_t, httplib::DataSink& sink) { return s->Serve(browser.get(), &sink); });
  });
  if (!s->http.bind_to_port(address.c_str(), port)) {
    *error = "cannot listen on " + address + ":" + std::to_string(port);
    return nullptr;
  }
  s->thread = std::thread([s] { s->http.listen_after_bind(); });
  return std::unique_ptr<LiveView>(new LiveView(std::move(server)));
}

LiveView::LiveView(std::unique_ptr<Server> server) : server_(std::move(server)) {}

LiveView::~LiveView() {
  {
    std::unique_lock<std::mutex> lock(server_->mutex);
    server_->changed.wait_for(lock, kPatience, [&] { return server_->AllServed(); });
    server_->stopping = true;
  }
  server_->changed.notify_all();
  while (!server_->http.is_running()) std::this_thread::yield();  // stop() before that is lost
  server_->http.stop();
  server_->thread.join();
}

void LiveView::Publish(const nlohmann::json& update) {
  std::string event = update.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  {
    const std::lock_guard<std::mutex> lock(server_->mutex);
    server_->events.push_back(std::move(event));
  }
  server_->changed.notify_all();
}

}  // namespace prism
