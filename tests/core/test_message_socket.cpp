// Two ends of a socket, of which one says what it likes.
#include "robsim/simulation/remote/message_socket.hpp"

#include <gtest/gtest.h>

#ifndef _WIN32

#include <pthread.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstring>
#include <limits>
#include <thread>

#include "robsim/base/system.hpp"

namespace robsim {
namespace {

constexpr double a_minute = 60;  // s
constexpr double always = std::numeric_limits<double>::infinity();
constexpr std::uint16_t answer = 4;
constexpr std::uint32_t most = 1 << 14;  // bytes

std::string head(std::uint16_t kind, std::uint32_t length, std::uint16_t zero = 0) {
  std::string bytes(8, 0);
  std::memcpy(&bytes[0], &kind, 2);
  std::memcpy(&bytes[2], &zero, 2);
  std::memcpy(&bytes[4], &length, 4);
  return bytes;
}

struct Ends {
  Ends() {
    int both[2];
    if (socketpair(AF_UNIX, SOCK_STREAM, 0, both) != 0) throw std::runtime_error("no sockets");
    one = both[0];
    other = both[1];
  }
  ~Ends() {
    ::close(one);
    hang_up();
  }
  void hang_up() {
    if (other >= 0) ::close(other);
    other = -1;
  }
  void say(const std::string& bytes) const {
    ASSERT_EQ(::send(other, bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
  }

  int one, other;
  MessageSocket careful(const std::function<void()>& interrupted = [] {}) const {
    return MessageSocket(one, {{{answer, most}}}, interrupted);
  }
};

TEST(MessageSocket, GivesBackWhatWasSent) {
  const Ends ends;
  MessageSocket socket = ends.careful();
  MessageSocket theirs(ends.other, std::nullopt, [] {});
  theirs.send(answer, {"ab", "", "cd"}, a_minute);
  const MessageSocket::Message message = socket.receive(always);
  EXPECT_EQ(message.kind, answer);
  EXPECT_EQ(message.body, "abcd");
  socket.send(3, {}, a_minute);
  EXPECT_EQ(theirs.receive(a_minute).body, "");
}

TEST(MessageSocket, PutsPiecesTogether) {
  const Ends ends;
  MessageSocket socket = ends.careful();
  const std::string body(most, 'x');
  std::thread speaker([&] {
    const std::string message = head(answer, most) + body;
    for (std::size_t at = 0; at < message.size(); at += at < 20 ? 1 : 5000) {
      ends.say(message.substr(at, at < 20 ? 1 : 5000));
      sleep_until(monotonic_now() + 1e-3);
    }
  });
  EXPECT_EQ(socket.receive(a_minute).body, body);
  speaker.join();
}

TEST(MessageSocket, SendsMoreThanTheSocketHolds) {
  const Ends ends;
  MessageSocket socket = ends.careful();
  MessageSocket theirs(ends.other, std::nullopt, [] {});
  const std::string part(3'000'000, 'a'), last(2'000'001, 'b');
  std::thread speaker([&] { socket.send(3, {part, last}, a_minute); });
  EXPECT_EQ(theirs.receive(a_minute).body, part + last);
  speaker.join();
}

TEST(MessageSocket, RefusesWhatIsNotDue) {
  const std::string wrong[] = {
      head(answer, most + 1), head(answer, 0xffffffff),
      head(answer, 0, 1),     head(3, 0),
      head(answer, 1) + "ab", head(answer, 0) + head(answer, 0),
      std::string(70'000, 0), head(answer, most, 0x100),
  };
  for (const std::string& bytes : wrong) {
    const Ends ends;
    MessageSocket socket = ends.careful();
    ends.say(bytes);
    EXPECT_THROW(socket.receive(a_minute), WrongMessage);
  }
}

TEST(MessageSocket, SaysThatTheOtherSideIsGone) {
  Ends ends;
  MessageSocket socket = ends.careful();
  ends.say(head(answer, 10) + "abc");
  ends.hang_up();
  EXPECT_THROW(socket.receive(a_minute), ConnectionEnd);
  EXPECT_THROW(socket.receive(a_minute), ConnectionEnd);
  EXPECT_THROW(socket.send(3, {"a"}, a_minute), ConnectionEnd);
}

TEST(MessageSocket, IsPatientForAWholeMessageOnly) {
  const Ends ends;
  MessageSocket socket = ends.careful();
  EXPECT_THROW(socket.receive(0), MessageTimeout);
  std::atomic<bool> ended{false};
  std::thread drip([&] {
    ends.say(head(answer, most));
    while (!ended) {
      ends.say("x");
      sleep_until(monotonic_now() + 1e-3);
    }
  });
  EXPECT_THROW(socket.receive(0.05), MessageTimeout);
  ended = true;
  drip.join();
  // Nobody reads.
  EXPECT_THROW(socket.send(3, {std::string(3'000'000, 'a')}, 0.02), MessageTimeout);
}

TEST(MessageSocket, LetsASignalEndAWait) {
  struct Stop {};
  const Ends ends;
  struct sigaction nothing{};
  struct sigaction before{};
  nothing.sa_handler = [](int) {};
  sigaction(SIGUSR1, &nothing, &before);
  int signals = 0;
  MessageSocket socket = ends.careful([&] {
    if (++signals == 3) throw Stop();
  });
  std::atomic<bool> ended{false};
  std::thread ringer([&ended, waiting = pthread_self()] {
    while (!ended) {
      pthread_kill(waiting, SIGUSR1);
      sleep_until(monotonic_now() + 1e-3);
    }
  });
  EXPECT_THROW(socket.receive(a_minute), Stop);
  ended = true;
  ringer.join();
  sigaction(SIGUSR1, &before, nullptr);
}

}  // namespace
}  // namespace robsim

#endif
