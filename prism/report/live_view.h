// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "prism/report/run_report.h"

namespace prism {

// Serves the report page over HTTP while a run goes on: "/" is the page, "/events" a stream of
// server-sent events, each an update {frames, trajectory, keyframes[, problems][, done]} as
// ReportToJson has them. A browser that comes late gets all that was before.
//
// Publish only appends to a list; browsers are served by other threads, so that neither a slow one
// nor one that goes away holds up the run.
class LiveView {
 public:
  // Serves on address:port; null if that cannot be had (then `error` says so). `run` gives the
  // page its title, options and camera.
  static std::unique_ptr<LiveView> Start(const std::string& address,
                                         int port,
                                         const RunReport& run,
                                         std::string* error);
  // Waits up to two seconds for browsers to take what is left, then ends the server.
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  void Publish(const nlohmann::json& update);

 private:
  struct Server;
  explicit LiveView(std::unique_ptr<Server> server);
  std::unique_ptr<Server> server_;
};

}  // namespace prism
