// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mutex>
#include <set>
#include <string>

#include <httplib.h>
#undef _res  // of resolv.h; Eigen has a parameter of that name

namespace prism {

// Whether a Host header names this machine by a number, as localhost, or as `address`: a page of
// another site that has a name of its own resolved to this machine (DNS rebinding) says that name.
bool IsOwnHost(const std::string& host_header, const std::string& address);

// The library's server, hardened for being open to whoever reaches the port: requests are GET, of
// an own Host (IsOwnHost), at most 16 KiB long and sent within five seconds; a reader that takes
// nothing for five seconds is cut off. Many connections may be idle or slow beside each other.
class GuardedServer : public httplib::Server {
 public:
  explicit GuardedServer(std::string address);

  // Ends all connections at once. What was written to them before arrives.
  void CutConnections();

 private:
  bool process_and_close_socket(socket_t socket) override;

  std::mutex mutex_;  // guards what follows
  std::set<socket_t> connections_;
  bool is_cut_ = false;
};

}  // namespace prism
