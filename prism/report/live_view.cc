// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/live_view.h"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>

#include "prism/report/guarded_server.h"

namespace prism {
namespace {

using Clock = std::chrono::steady_clock;

// How often a stream without news is written to, to notice that the browser has gone.
constexpr auto kHeartbeat = std::chrono::seconds(1);
// At the end.
constexpr auto kPageLoadTime = std::chrono::milliseconds(800);
constexpr auto kLongestEnd = std::chrono::seconds(1);
constexpr size_t kEventsAtOnce = 8;  // written together

using Update = std::shared_ptr<const RunUpdate>;

std::string ToEventData(const RunUpdate& update) {
  nlohmann::json json = {{"frames", nlohmann::json::array()},
                         {"trajectory", nlohmann::json::array()},
                         {"keyframes", nlohmann::json::array()}};
  for (const ReportFrame& frame : update.frames) {
    json["frames"].push_back(FrameToReportJson(frame));
  }
  for (const Eigen::Vector3d& position : update.positions) {
    for (int i = 0; i < 3; ++i) json["trajectory"].push_back(position(i));
  }
  for (const RunUpdate::Keyframe& keyframe : update.keyframes) {
    json["keyframes"].push_back(KeyframeToReportJson(keyframe.keyframe));
    json["keyframes"].back()["index"] = keyframe.index;
  }
  if (!update.problems.empty()) json["problems"] = update.problems;
  if (update.finished) {
    RunReport report = *update.finished;
    report.keyframes.clear();
    json["finished"] = ReportToJson(report);
    // What the browser has is more than a page of a long run would hold of them.
    json["finished"].erase("keyframes");
  }
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

bool HasImage(const RunUpdate& update) {
  return std::any_of(update.keyframes.begin(), update.keyframes.end(), [](const auto& entry) {
    return !entry.keyframe.jpeg.empty();
  });
}

Update WithoutImages(const RunUpdate& update) {
  auto copy = std::make_shared<RunUpdate>(update);
  for (RunUpdate::Keyframe& entry : copy->keyframes) {
    entry.keyframe.DropPictures();
  }
  return copy;
}

// All updates of a run, of the older ones without images.
class History {
 public:
  size_t size() const { return updates_.size(); }

  void Add(RunUpdate update) {
    if (HasImage(update)) with_image_.push_back(updates_.size());
    updates_.push_back(std::make_shared<const RunUpdate>(std::move(update)));
    if (with_image_.size() <= LiveView::kImagesHeld) return;
    for (; stripped_ <= with_image_.front(); ++stripped_) {
      if (updates_[stripped_]->keyframes.empty()) continue;
      updates_[stripped_] = WithoutImages(*updates_[stripped_]);
    }
    with_image_.pop_front();
  }

  std::vector<Update> From(size_t begin) const {
    const size_t end = std::min(begin + kEventsAtOnce, updates_.size());
    return {updates_.begin() + static_cast<std::ptrdiff_t>(begin),
            updates_.begin() + static_cast<std::ptrdiff_t>(end)};
  }

 private:
  std::vector<Update> updates_;
  std::deque<size_t> with_image_;  // updates that have one
  size_t stripped_ = 0;            // updates before this one have no images
};

}  // namespace

struct LiveView::Server {
  struct Browser {
    size_t next = 0;  // update to send
    bool is_of_other_run = false;
  };

  explicit Server(const std::string& address) : http(address) {}

  GuardedServer http;
  std::thread thread;
  std::string page;
  // Tells this run's event ids from those of one before on the same port.
  const std::string run_id =
      std::to_string(getpid()) + "." + std::to_string(Clock::now().time_since_epoch().count());

  std::mutex mutex;  // guards what follows
  std::condition_variable changed;
  History history;
  std::vector<std::shared_ptr<Browser>> browsers;
  int pages_loading = 0;  // asked for, their streams not yet
  Clock::time_point last_page_time;
  bool stopping = false;

  void PageAskedFor() {
    const std::lock_guard<std::mutex> lock(mutex);
    ++pages_loading;
    last_page_time = Clock::now();
  }

  std::shared_ptr<Browser> AddBrowser(const std::string& last_event_id) {
    auto browser = std::make_shared<Browser>();
    const size_t separator = last_event_id.find('-');
    const std::lock_guard<std::mutex> lock(mutex);
    if (last_event_id.empty()) {
      pages_loading = std::max(0, pages_loading - 1);
    } else if (separator != std::string::npos && last_event_id.substr(0, separator) == run_id) {
      browser->next = std::min<size_t>(
          std::strtoull(last_event_id.c_str() + separator + 1, nullptr, 10), history.size());
    } else {
      browser->is_of_other_run = true;
    }
    browsers.push_back(browser);
    changed.notify_all();
    return browser;
  }

  void RemoveBrowser(const std::shared_ptr<Browser>& browser) {
    const std::lock_guard<std::mutex> lock(mutex);
    browsers.erase(std::remove(browsers.begin(), browsers.end(), browser), browsers.end());
    changed.notify_all();
  }

  // Writes what a browser has not got yet; false ends its stream.
  bool Serve(Browser* browser, httplib::DataSink* sink) {
    if (browser->is_of_other_run) {
      const std::string text = "data: {\"reload\":true}\n\n";
      sink->write(text.data(), text.size());
      sink->done();
      return true;
    }
    std::vector<Update> updates;
    bool is_end = false;
    {
      std::unique_lock<std::mutex> lock(mutex);
      changed.wait_for(
          lock, kHeartbeat, [&] { return stopping || browser->next < history.size(); });
      updates = history.From(browser->next);
      is_end = stopping && updates.empty();
    }
    if (is_end) {
      sink->done();
      return true;
    }
    std::string text;
    size_t next = browser->next;
    for (const Update& update : updates) {
      text += "id: " + run_id + "-" + std::to_string(++next) + "\ndata: " + ToEventData(*update) +
              "\n\n";
    }
    if (text.empty()) text = ": still here\n\n";
    const bool is_written = sink->write(text.data(), text.size());
    const std::lock_guard<std::mutex> lock(mutex);
    browser->next = next;
    changed.notify_all();
    return is_written;
  }

  // Ends all streams once their browsers have all updates, or there is no hope for that.
  void WaitForBrowsers() {
    std::unique_lock<std::mutex> lock(mutex);
    changed.wait_until(lock, last_page_time + kPageLoadTime, [&] { return pages_loading == 0; });
    stopping = true;
    changed.notify_all();
    // Each stream should come to its orderly end: what a browser has not taken of one that is cut
    // off is lost to it. But nobody may hold up the program.
    changed.wait_until(lock, Clock::now() + kLongestEnd, [&] { return browsers.empty(); });
  }
};

std::unique_ptr<LiveView> LiveView::Start(const std::string& address,
                                          int port,
                                          const RunReport& run,
                                          std::string* error) {
  auto server = std::make_unique<Server>(address);
  Server* const s = server.get();
  s->page = FormatReport(run, true);
  // The library's default would let two runs share a port, and browsers get now one, now the other.
  s->http.set_socket_options([](socket_t socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  });
  s->http.Get("/", [s](const httplib::Request&, httplib::Response& response) {
    s->PageAskedFor();
    response.set_content(s->page, "text/html; charset=utf-8");
  });
  s->http.Get("/events", [s](const httplib::Request& request, httplib::Response& response) {
    response.set_header("Cache-Control", "no-store");
    const auto browser = s->AddBrowser(request.get_header_value("Last-Event-ID"));
    response.set_chunked_content_provider(
        "text/event-stream",
        [s, browser](size_t, httplib::DataSink& sink) { return s->Serve(browser.get(), &sink); },
        [s, browser](bool) { s->RemoveBrowser(browser); });
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
  server_->WaitForBrowsers();
  while (!server_->http.is_running()) std::this_thread::yield();  // stop() before that is lost
  server_->http.stop();
  server_->http.CutConnections();
  server_->thread.join();
}

void LiveView::Publish(RunUpdate update) {
  {
    const std::lock_guard<std::mutex> lock(server_->mutex);
    server_->history.Add(std::move(update));
  }
  server_->changed.notify_all();
}

}  // namespace prism
