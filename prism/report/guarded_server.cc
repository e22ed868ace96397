// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/report/guarded_server.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <utility>

namespace prism {
namespace {

using Clock = std::chrono::steady_clock;

constexpr size_t kThreads = 256;  // each serves one connection, most of them asleep
constexpr size_t kMaxRequestBytes = 16384;
constexpr auto kPatience = std::chrono::seconds(5);
constexpr int kMaxRequests = 20;  // of one connection

bool WaitFor(socket_t socket, short events, Clock::time_point end) {
  pollfd waiting = {socket, events, 0};
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
  const int timeout = static_cast<int>(std::max<int64_t>(left.count(), 0));
  return poll(&waiting, 1, timeout) > 0 && (waiting.revents & (events | POLLHUP)) != 0;
}

// One request and its answer.
class GuardedStream : public httplib::Stream {
 public:
  explicit GuardedStream(socket_t socket) : socket_(socket) {}

  bool is_readable() const override { return left_ > 0 && WaitFor(socket_, POLLIN, read_end_); }
  bool is_writable() const override { return WaitFor(socket_, POLLOUT, Clock::now() + kPatience); }

  ssize_t read(char* data, size_t size) override {
    if (!is_readable()) return -1;
    const ssize_t count = recv(socket_, data, std::min(size, left_), 0);
    if (count > 0) left_ -= static_cast<size_t>(count);
    return count;
  }
  ssize_t write(const char* data, size_t size) override {
    return is_writable() ? send(socket_, data, size, MSG_NOSIGNAL | MSG_DONTWAIT) : -1;
  }

  void get_remote_ip_and_port(std::string& ip, int& port) const override { Address(ip, port); }
  void get_local_ip_and_port(std::string& ip, int& port) const override { Address(ip, port); }
  socket_t socket() const override { return socket_; }

 private:
  // Nobody asks for them; the library wants something.
  static void Address(std::string& ip, int& port) {
    ip = "";
    port = 0;
  }

  socket_t socket_;
  size_t left_ = kMaxRequestBytes;
  Clock::time_point read_end_ = Clock::now() + kPatience;
};

bool IsNumeric(const std::string& host) {
  in6_addr ignored;
  return inet_pton(AF_INET, host.c_str(), &ignored) == 1 ||
         inet_pton(AF_INET6, host.c_str(), &ignored) == 1;
}

}  // namespace

bool IsOwnHost(const std::string& host_header, const std::string& address) {
  std::string host = host_header;
  if (!host.empty() && host[0] == '[') {
    const size_t end = host.find(']');
    if (end == std::string::npos) return false;
    host = host.substr(1, end - 1);
  } else {
    host.resize(std::min(host.find(':'), host.size()));
  }
  std::transform(host.begin(), host.end(), host.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return host == "localhost" || host == address || IsNumeric(host);
}

GuardedServer::GuardedServer(std::string address) {
  new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
  set_payload_max_length(kMaxRequestBytes);
  set_pre_routing_handler(
      [address = std::move(address)](const httplib::Request& request, httplib::Response& response) {
        using Result = httplib::Server::HandlerResponse;
        if (!IsOwnHost(request.get_header_value("Host"), address)) {
          response.status = 403;
        } else if (request.method != "GET") {
          response.status = 405;
        } else {
          return Result::Unhandled;
        }
        response.set_header("Connection", "close");
        return Result::Handled;
      });
}

void GuardedServer::CutConnections() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_cut_ = true;
  for (const socket_t socket : connections_) shutdown(socket, SHUT_RDWR);
}

bool GuardedServer::process_and_close_socket(socket_t socket) {
  bool is_welcome = true;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_welcome = !is_cut_;
    if (is_welcome) connections_.insert(socket);
  }
  bool is_closed = !is_welcome;
  for (int i = 1; i <= kMaxRequests && !is_closed; ++i) {
    if (!WaitFor(socket, POLLIN, Clock::now() + kPatience)) break;
    GuardedStream stream(socket);
    if (!process_request(stream, i == kMaxRequests, is_closed, nullptr)) break;
  }
  shutdown(socket, SHUT_RDWR);
  const std::lock_guard<std::mutex> lock(mutex_);
  connections_.erase(socket);
  close(socket);
  return is_welcome;
}

}  // namespace prism
