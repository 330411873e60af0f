#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace robsim {

/// A line to a robot, or from one, does not work: the message names it.
class LineError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One end of a line that text goes over: UDP, or a file descriptor, such as that of a serial port.
/// For one thread at a time. It never blocks, but for the patience that it is given.
class Line {
 public:
  /// Sends to this host. Throws LineError.
  static Line udp_to(const std::string& host, int port);

  /// Listens at this address; port 0 = any that is free. What is written goes to whom it heard
  /// last. Throws LineError.
  static Line udp_at(const std::string& host, int port);

  /// Takes a copy of the descriptor; makes its file non-blocking. Throws LineError.
  static Line of_descriptor(int descriptor, const std::string& name);

  Line(Line&& other) noexcept;
  Line& operator=(Line&&) = delete;
  ~Line();

  const std::string& name() const { return name_; }
  int port() const { return port_; }  // 0: it has none

  /// Writes all of a line, or throws LineError if that lasts longer (s).
  void write(std::string_view text, double patience);

  struct Piece {
    std::string bytes;
    std::string source;     // the address it came from, of UDP
    bool is_whole = false;  // a datagram: lines begin and end with it
  };

  /// What has arrived; none if nothing has. Throws LineError; if the other end of a descriptor is
  /// gone, once: then nothing more is read.
  std::optional<Piece> read();

  /// Waits until there is something to read, a `Wake` rings, or a time (s) is over.
  class Wake;
  void wait(const Wake& wake, double time) const;

  void close();

  /// Reads again, as the other end may be back.
  void read_again() { is_deaf_ = false; }

 private:
  Line(int descriptor, std::string name, bool is_socket);

  [[noreturn]] void fail(const char* what, int error) const;
  bool write_some(std::string_view& text);

  int descriptor_;
  std::string name_;
  bool is_socket_;
  bool is_listening_ = false;
  bool is_deaf_ = false;
  bool is_broken_off_ = false;  // the last line was written in part
  int port_ = 0;
  std::string peer_;  // whom a listening socket answers: a sockaddr
};

/// Ends a wait, from any thread.
class Line::Wake {
 public:
  Wake();
  ~Wake();
  Wake(const Wake&) = delete;
  Wake& operator=(const Wake&) = delete;

  void ring() const;

 private:
  friend class Line;
  int ends_[2];  // of a pipe: read, write
};

}  // namespace robsim
