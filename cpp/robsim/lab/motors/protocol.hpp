#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "robsim/model/robot_model.hpp"

namespace robsim {

/// A line of the protocol that PROTOCOL.md describes.
struct Command {
  enum class Kind { input, stop, answer };

  Kind kind = Kind::stop;
  std::uint16_t number = 0;
  Input u;
  int time_to_live = 0;  // ms; an answer has none
};

/// No line of the protocol is longer (characters, with its line break).
constexpr std::size_t longest_line = 48;
constexpr int longest_time_to_live = 60'000;  // ms
constexpr double largest_voltage = 999.9999;  // V

/// The input that a robot reads in the line of this one: rounded to 0.1 mV.
Input as_written(const Input& u);

/// The line, with its line break. Throws std::invalid_argument for what does not fit into one.
std::string to_line(const Command& command);

/// What a line says, without its line break; none if it is damaged.
std::optional<Command> parse_line(std::string_view line);

/// Whether a line follows another one of this number: numbers begin again at 0 after 65535.
bool is_newer(std::uint16_t number, std::uint16_t than);

/// CRC-16/XMODEM.
std::uint16_t checksum(std::string_view text);

/// Cuts what arrives, in any pieces, into lines; leaves out blank ones.
class LineReader {
 public:
  /// The lines that are complete with these bytes, without their line breaks; an empty one in place
  /// of each that was too long.
  std::vector<std::string> read(std::string_view bytes);

  /// What arrives next begins a line.
  void clear();

 private:
  std::string begun_;
  bool is_too_long_ = false;
};

/// What went over a line, or what a robot did by itself.
struct MotorEvent {
  enum class Kind {
    input,    // a new one
    repeat,   // the same once more, so that the robot goes on
    stop,     // it was told to
    failure,  // a line that could not be written
    timeout,  // the robot stopped by itself: it had heard nothing for the time to live
    silence,  // the robot, which had answered before, has not for a second
  };

  double t = 0;  // monotonic, s
  Input u;
  Kind kind = Kind::input;
};

/// The newest events.
class EventLog {
 public:
  void add(const MotorEvent& event) {
    if (events_.size() == most) events_.pop_front();
    events_.push_back(event);
  }

  std::vector<MotorEvent> get() const { return {events_.begin(), events_.end()}; }

 private:
  static constexpr std::size_t most = 100'000;
  std::deque<MotorEvent> events_;
};

}  // namespace robsim
