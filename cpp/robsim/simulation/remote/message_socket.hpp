#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace robsim {

/// One end of a stream socket between two processes that speak in turn: there is one message at a
/// time. A message is a head of eight bytes (kind, 0, length of the body; little endian) and its
/// body. On Windows, making one throws std::runtime_error.
class MessageSocket {
 public:
  /// The most bytes of the kinds that may come; nothing: all may, of any length, from who is
  /// trusted.
  using Limits = std::optional<std::map<std::uint16_t, std::uint32_t>>;

  struct Message {
    std::uint16_t kind = 0;
    std::string_view body;  // until the next call
  };

  /// The descriptor must stay open as long as this lives. `interrupted` is called when a signal
  /// ends a wait, and may throw.
  MessageSocket(int descriptor, Limits limits, std::function<void()> interrupted);

  /// Sends a message whose body has these parts. `patience` (s) is for all of it. Throws
  /// MessageTimeout, ConnectionEnd, std::system_error.
  void send(std::uint16_t kind, const std::vector<std::string_view>& parts, double patience);

  /// The next message, whole. Throws what `send` throws, and WrongMessage: for one of a kind that
  /// is not due, a longer one, or more than one.
  Message receive(double patience);

 private:
  struct Head;

  Head head() const;
  std::size_t receive_some(char* to, std::size_t size, double deadline, std::size_t have);
  void wait_for(short events, double deadline) const;

  int descriptor_;
  Limits limits_;
  std::function<void()> interrupted_;
  std::vector<char> buffer_;  // of a message, as long as it is short
  std::vector<char> long_body_;
};

class MessageTimeout : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class ConnectionEnd : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class WrongMessage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace robsim
