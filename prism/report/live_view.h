// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prism/report/run_report.h"

namespace prism {

// What a run has to tell since it last did.
struct RunUpdate {
  struct Keyframe {
    int index = 0;  // rising without gaps
    // Of a keyframe told of before: its pose and points of now, without image.
    ReportKeyframe keyframe;
  };
  std::vector<ReportFrame> frames;
  std::vector<Eigen::Vector3d> positions;  // of the tracked frames among them, in the world
  std::vector<Keyframe> keyframes;
  std::vector<std::string> problems;  // all of the run, where one has come
  // At the end: the whole run. Of its frames and keyframes nothing is sent again.
  std::shared_ptr<const RunReport> finished;
};

// Serves the report page over HTTP while a run goes on: "/" is the page, "/events" a stream of
// server-sent events, a RunUpdate each. A browser that comes late gets all that was before, and
// one whose connection broke what it missed (Last-Event-ID).
//
// Publish only appends to a list; updates are encoded and sent by the threads that serve browsers,
// so that without a browser nothing is encoded and neither a slow one nor one that goes away holds
// up the run. Requests are bounded, and those of a foreign Host refused (GuardedServer). Of the
// keyframes, the images and points of the latest 64 are held; of older ones a browser that comes
// late gets the poses. What is held beside them grows by the frames' figures, some 0.6 kB each.
class LiveView {
 public:
  static constexpr size_t kImagesHeld = 64;

  // Serves on address:port; null if that cannot be had (then `error` says so). `run` gives the
  // page its title, options and camera.
  static std::unique_ptr<LiveView> Start(const std::string& address,
                                         int port,
                                         const RunReport& run,
                                         std::string* error);
  // Ends the server once browsers have got what is left, within two seconds: one for that, and
  // before it nearly one for a page that was asked for just now to open its stream.
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  void Publish(RunUpdate update);

 private:
  struct Server;
  explicit LiveView(std::unique_ptr<Server> server);
  std::unique_ptr<Server> server_;
};

}  // namespace prism
