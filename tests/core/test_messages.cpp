// Messages between a grader and a submission: the bytes of a step, and two ends of a socket.
#include <gtest/gtest.h>

#ifndef _WIN32
#include <pthread.h>
#include <sys/socket.h>
#include <unistd.h>
#endif

#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <thread>

#include "robsim/base/system.hpp"
#include "robsim/simulation/remote/message_socket.hpp"
#include "robsim/simulation/remote/step_message.hpp"

namespace robsim {
namespace {

// --- the bytes of a step

StepMessage full_message() {
  StepMessage message;
  message.k = 7;
  message.t = 1.4;
  message.done = measure_bit | estimate_bit | control_bit;
  message.measurement = Measurement();
  message.measurement->pose = {120.5, 80.25, 0.5};
  Estimate estimate;
  estimate.pose = {120, 80, 0.4};
  estimate.covariance.setIdentity();
  message.estimate = estimate;
  message.u = Input();
  message.blobs = {{1.5, 2.5}, {3.5, 4.5}};
  message.next_slot = 2;
  return message;
}

TEST(StepMessage, ComesBackAsItWas) {
  const std::string bytes = to_bytes(full_message());
  const StepMessage back = message_from(bytes.data(), bytes.size());
  EXPECT_EQ(back.k, 7);
  EXPECT_EQ(back.t, 1.4);
  EXPECT_EQ(back.done, measure_bit | estimate_bit | control_bit);
  ASSERT_TRUE(back.measurement && back.estimate && back.u);
  EXPECT_EQ(back.measurement->pose.x, 120.5);
  EXPECT_EQ(back.estimate->covariance(2, 2), 1);
  ASSERT_EQ(back.blobs.size(), 2);
  EXPECT_EQ(back.blobs[1].y, 4.5);
  EXPECT_FALSE(back.frame || back.sample || back.parameters);
  EXPECT_EQ(to_bytes(back), bytes);
}

TEST(StepMessage, IsRefusedWhereItIsCutOrTooLong) {
  const std::string bytes = to_bytes(full_message());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const std::string cut = bytes.substr(0, size);  // of its own, so that reading beyond is seen
    EXPECT_THROW(message_from(cut.data(), cut.size()), MessageError) << size;
  }
  const std::string longer = bytes + '\0';
  EXPECT_THROW(message_from(longer.data(), longer.size()), MessageError);
}

TEST(StepMessage, OfNumbersThatCannotBeIsRefused) {
  StepMessage message = full_message();
  message.estimate->covariance(1, 1) = -1;
  std::string bytes = to_bytes(message);
  EXPECT_THROW(message_from(bytes.data(), bytes.size()), MessageError);
  message = full_message();
  message.estimate->pose.x = std::numeric_limits<double>::quiet_NaN();
  bytes = to_bytes(message);
  EXPECT_THROW(message_from(bytes.data(), bytes.size()), MessageError);
}

// What is accepted can be sent on: nothing in it leads beyond the message.
TEST(StepMessage, OfRandomBytesIsRefusedOrWhole) {
  std::mt19937 random(11);
  const std::string whole = to_bytes(full_message());
  int accepted = 0;
  for (int i = 0; i < 50000; ++i) {
    std::string bytes = whole;
    const auto changes = 1 + random() % 8;
    for (unsigned j = 0; j < changes; ++j) {
      bytes[random() % bytes.size()] = static_cast<char>(random() % 256);
    }
    if (random() % 4 == 0) bytes.resize(random() % (2 * bytes.size()));
    try {
      const StepMessage message = message_from(bytes.data(), bytes.size());
      EXPECT_EQ(to_bytes(message).size(), bytes.size());
      ++accepted;
    } catch (const MessageError&) {
    }
  }
  EXPECT_GT(accepted, 0);
  EXPECT_LT(accepted, 50000);
}

// --- two ends of a socket

#ifndef _WIN32

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

#endif

}  // namespace
}  // namespace robsim
