// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
// The live view's port is open to whoever reaches it.
#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prism/report/guarded_server.h"
#include "prism/report/live_view.h"

namespace prism {
namespace {

using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

// A TCP connection that does only what it is told.
class Connection {
 public:
  explicit Connection(int port) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    // Takes little, so that whoever sends much has to wait.
    const int size = 4096;
    setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &size, sizeof(size));
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(port));
    inet_pton(AF_INET, "127.0.0.1", &address.sin_addr);
    is_open_ = connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0;
  }
  ~Connection() { close(socket_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  bool is_open() const { return is_open_; }
  // False once the other side has gone.
  bool Send(const std::string& text) const {
    return send(socket_, text.data(), text.size(), MSG_NOSIGNAL) ==
           static_cast<ssize_t>(text.size());
  }
  std::string Receive() const {
    char buffer[2048];
    const ssize_t count = recv(socket_, buffer, sizeof(buffer), 0);
    return std::string(buffer, static_cast<size_t>(std::max<ssize_t>(count, 0)));
  }

 private:
  int socket_;
  bool is_open_ = false;
};

class LiveViewAttack : public testing::Test {
 protected:
  LiveViewAttack() {
    std::string error;
    RunReport run;
    run.title = "<!--<script>alert(1)</script>";
    for (port_ = 38200; port_ < 38300 && !live_; ++port_) {
      live_ = LiveView::Start("127.0.0.1", port_, run, &error);
    }
    --port_;
  }

  std::string Answer(const std::string& request) const {
    const Connection connection(port_);
    connection.Send(request);
    return connection.Receive();
  }
  double SecondsToThePage() const {
    const Clock::time_point begin = Clock::now();
    EXPECT_THAT(Answer("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"), HasSubstr("200 OK"));
    return SecondsSince(begin);
  }

  int port_ = 0;
  std::unique_ptr<LiveView> live_;
};

TEST(IsOwnHost, IsANumberLocalhostOrTheAddress) {
  for (const char* host : {"localhost",
                           "LocalHost:80",
                           "127.0.0.1:8080",
                           "[::1]:8080",
                           "10.1.2.3",
                           "robot.lan:8080"}) {
    EXPECT_TRUE(IsOwnHost(host, "robot.lan")) << host;
  }
  for (const char* host : {"",
                           "evil.example",
                           "evil.example:8080",
                           "127.0.0.1.evil.example",
                           "localhost.evil.example",
                           "[::1",
                           "[evil]"}) {
    EXPECT_FALSE(IsOwnHost(host, "robot.lan")) << host;
  }
}

TEST_F(LiveViewAttack, AForeignHostGetsNothing) {
  ASSERT_NE(live_, nullptr);
  for (const char* path : {"/", "/events"}) {
    const std::string get = std::string("GET ") + path + " HTTP/1.1\r\n";
    EXPECT_THAT(Answer(get + "Host: evil.example\r\n\r\n"), HasSubstr("403")) << path;
    EXPECT_THAT(Answer(get + "\r\n"), HasSubstr("403")) << path;
  }
  SecondsToThePage();
}

TEST_F(LiveViewAttack, BodiesHeadersAndGarbageAreBounded) {
  ASSERT_NE(live_, nullptr);
  EXPECT_THAT(Answer("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 157286400\r\n\r\n"),
              HasSubstr("405"));
  EXPECT_THAT(Answer("GET /../../etc/passwd HTTP/1.1\r\nHost: localhost\r\n\r\n"),
              testing::Not(HasSubstr("200")));
  const Connection endless(port_);
  endless.Send("GET / HTTP/1.1\r\n");
  bool is_open = true;
  for (int i = 0; i < 10000 && is_open; ++i) {
    is_open = endless.Send("X-" + std::to_string(i) + ": " + std::string(1000, 'x') + "\r\n");
  }
  EXPECT_FALSE(is_open) << "10 MB of headers were taken";
  Answer(std::string(3000, '\xff') + "\r\n\r\n");
  SecondsToThePage();
}

TEST_F(LiveViewAttack, TwoHundredIdleAndSlowClientsHoldUpNeitherPageNorEnd) {
  ASSERT_NE(live_, nullptr);
  RunUpdate update;
  update.keyframes.resize(1);
  update.keyframes[0].keyframe.jpeg = std::string(6 << 20, 'x');  // more than sockets hold
  live_->Publish(std::move(update));
  std::vector<std::unique_ptr<Connection>> clients;
  for (int i = 0; i < 200; ++i) {
    clients.push_back(std::make_unique<Connection>(port_));
    ASSERT_TRUE(clients.back()->is_open());
    if (i % 20 == 1) clients.back()->Send("GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n");
    if (i % 20 == 2) clients.back()->Send("GET / HT");
  }
  EXPECT_LT(SecondsToThePage(), 2);
  const Clock::time_point begin = Clock::now();
  live_.reset();
#ifdef __SANITIZE_THREAD__  // which slows it down by five to fifteen times
  constexpr double kLongest = 20;
#else
  constexpr double kLongest = 3;  // 2 s and a busy machine
#endif
  EXPECT_LT(SecondsSince(begin), kLongest);
}

}  // namespace
}  // namespace prism
