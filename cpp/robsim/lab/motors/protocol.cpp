#include "robsim/lab/motors/protocol.hpp"

#include <charconv>
#include <cmath>
#include <stdexcept>

#include "robsim/base/system.hpp"

namespace robsim {

namespace {

// Voltages are written as whole multiples of it, so that no locale and no rounding comes in.
constexpr double units_per_volt = 10'000;

long long units_of(double voltage, const char* name) {
  if (!(std::abs(voltage) <= largest_voltage)) {
    throw std::invalid_argument(std::string(name) + " must lie within -" +
                                to_text(largest_voltage) + ".." + to_text(largest_voltage) +
                                " V, got " + to_text(voltage));
  }
  return std::llround(voltage * units_per_volt);
}

std::string voltage_text(long long units) {
  const long long size = std::abs(units);
  std::string decimals = std::to_string(size % 10'000);
  decimals.insert(0, 4 - decimals.size(), '0');
  return (units < 0 ? "-" : "") + std::to_string(size / 10'000) + "." + decimals;
}

std::string checksum_text(std::string_view text) {
  const char* const digits = "0123456789ABCDEF";
  const std::uint16_t sum = checksum(text);
  std::string hex;
  for (int shift = 12; shift >= 0; shift -= 4) hex += digits[(sum >> shift) & 15];
  return hex;
}

// A line, eaten up from its left.
class Words {
 public:
  explicit Words(std::string_view text) : text_(text) {}

  bool is_empty() const { return text_.empty(); }

  std::optional<std::string_view> next() {
    const std::size_t end = text_.find(' ');
    if (end == 0 || end == std::string_view::npos) return std::nullopt;
    const std::string_view word = text_.substr(0, end);
    text_.remove_prefix(end + 1);
    return word;
  }

  std::optional<int> whole_number(int most) {
    const auto word = next();
    return word ? parsed(*word, most) : std::nullopt;
  }

  std::optional<double> voltage() {
    auto word = next();
    if (!word) return std::nullopt;
    const bool is_negative = word->front() == '-';
    if (is_negative) word->remove_prefix(1);
    const std::size_t point = word->find('.');
    if (point == std::string_view::npos || word->size() != point + 5) return std::nullopt;
    const auto volts = parsed(word->substr(0, point), 999);
    const auto decimals = parsed(word->substr(point + 1), 9999);
    if (!volts || !decimals) return std::nullopt;
    const int units = 10'000 * *volts + *decimals;
    return (is_negative ? -units : units) / units_per_volt;
  }

 private:
  static std::optional<int> parsed(std::string_view digits, int most) {
    if (digits.empty() || digits.size() > 5) return std::nullopt;
    if (digits.find_first_not_of("0123456789") != std::string_view::npos) return std::nullopt;
    int value = 0;
    std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return value <= most ? std::optional(value) : std::nullopt;
  }

  std::string_view text_;
};

std::optional<Command> parse_words(Words words) {
  Command command;
  const std::string_view word = words.next().value_or("");
  if (word == "u") {
    command.kind = Command::Kind::input;
  } else if (word == "a") {
    command.kind = Command::Kind::answer;
  } else if (word != "s") {
    return std::nullopt;
  }
  const auto number = words.whole_number(65535);
  if (!number) return std::nullopt;
  command.number = static_cast<std::uint16_t>(*number);
  if (command.kind == Command::Kind::input) {
    const auto u1 = words.voltage();
    const auto u2 = words.voltage();
    if (!u1 || !u2) return std::nullopt;
    command.u = {*u1, *u2};
  }
  if (command.kind != Command::Kind::answer) {
    const auto time_to_live = words.whole_number(longest_time_to_live);
    if (!time_to_live || *time_to_live == 0) return std::nullopt;
    command.time_to_live = *time_to_live;
  }
  return words.is_empty() ? std::optional(command) : std::nullopt;
}

}  // namespace

Input as_written(const Input& u) {
  return {static_cast<double>(units_of(u.u1, "u1")) / units_per_volt,
          static_cast<double>(units_of(u.u2, "u2")) / units_per_volt};
}

std::string to_line(const Command& command) {
  const bool is_input = command.kind == Command::Kind::input;
  const bool is_answer = command.kind == Command::Kind::answer;
  std::string text = is_input ? "u " : is_answer ? "a " : "s ";
  text += std::to_string(command.number) + " ";
  if (is_input) {
    text += voltage_text(units_of(command.u.u1, "u1")) + " ";
    text += voltage_text(units_of(command.u.u2, "u2")) + " ";
  }
  if (!is_answer) {
    if (command.time_to_live < 1 || command.time_to_live > longest_time_to_live) {
      throw std::invalid_argument("the time to live must lie within 1.." +
                                  std::to_string(longest_time_to_live) + " ms, got " +
                                  std::to_string(command.time_to_live));
    }
    text += std::to_string(command.time_to_live) + " ";
  }
  return text + "*" + checksum_text(text) + "\n";
}

std::optional<Command> parse_line(std::string_view line) {
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  const std::size_t star = line.rfind('*');
  if (star == std::string_view::npos || line.size() >= longest_line) return std::nullopt;
  const std::string_view text = line.substr(0, star);
  if (line.substr(star + 1) != checksum_text(text)) return std::nullopt;
  return parse_words(Words(text));
}

bool is_newer(std::uint16_t number, std::uint16_t than) {
  const auto ahead = static_cast<std::uint16_t>(number - than);
  return ahead != 0 && ahead < 0x8000;
}

std::uint16_t checksum(std::string_view text) {
  unsigned sum = 0;
  for (const char c : text) {
    sum ^= static_cast<unsigned>(static_cast<unsigned char>(c)) << 8;
    for (int bit = 0; bit < 8; ++bit) sum = sum & 0x8000 ? (sum << 1) ^ 0x1021 : sum << 1;
  }
  return static_cast<std::uint16_t>(sum);
}

std::vector<std::string> LineReader::read(std::string_view bytes) {
  std::vector<std::string> lines;
  for (const char c : bytes) {
    if (c == '\n') {
      if (is_too_long_) begun_.clear();
      if (is_too_long_ || !begun_.empty()) lines.push_back(begun_);
      clear();
    } else if (begun_.size() + 1 >= longest_line) {
      is_too_long_ = true;
    } else {
      begun_ += c;
    }
  }
  return lines;
}

void LineReader::clear() {
  begun_.clear();
  is_too_long_ = false;
}

}  // namespace robsim
