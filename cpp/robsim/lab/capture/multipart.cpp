#include "robsim/lab/capture/multipart.hpp"

#include <algorithm>
#include <charconv>
#include <stdexcept>

namespace robsim {

namespace {

constexpr std::size_t none = std::string::npos;
constexpr std::size_t longest_part = std::size_t{1} << 26;  // bytes
constexpr std::size_t longest_head = std::size_t{1} << 16;
constexpr std::size_t longest_size_line = 1024;
constexpr std::string_view jpeg_end = "\xff\xd9";

// Where a head that begins at `from` ends: after its blank line. Some cameras send no carriage
// returns.
std::size_t end_of_head(const std::string& data, std::size_t from) {
  for (std::size_t at = data.find('\n', from); at != none; at = data.find('\n', at + 1)) {
    const std::size_t next = data.find_first_not_of('\r', at + 1);
    if (next != none && data[next] == '\n') return next + 1;
  }
  return none;
}

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

std::optional<std::size_t> content_length(std::string head) {
  constexpr std::string_view name = "\ncontent-length:";
  std::transform(head.begin(), head.end(), head.begin(), lower);
  const std::size_t at = head.find(name);
  if (at == none) return std::nullopt;
  const std::size_t first = head.find_first_not_of(" \t", at + name.size());
  std::size_t length = 0;
  if (first == none) return std::nullopt;
  const auto read = std::from_chars(&head[first], head.data() + head.size(), length);
  const bool is_number = read.ec == std::errc() && length <= longest_part;
  return is_number ? std::optional(length) : std::nullopt;
}

}  // namespace

Multipart::Multipart(std::string_view boundary) {
  boundary.remove_prefix(std::min(boundary.find_first_not_of('-'), boundary.size()));
  marker_ = "--" + std::string(boundary);
}

std::optional<std::string> Multipart::next() {
  if (!is_in_body_ && !skip_head()) return std::nullopt;
  std::optional<std::size_t> end = end_of_body();
  if (!end && data_.size() > longest_part) end = data_.size();
  if (!end) return std::nullopt;
  std::string body = data_.substr(0, *end);
  data_.erase(0, *end);
  is_in_body_ = false;
  return body;
}

// The marker where a line ends with it: a short one alone may stand in an image by chance.
std::size_t Multipart::find_marker(std::size_t from) const {
  for (std::size_t at = data_.find(marker_, from); at != none; at = data_.find(marker_, at + 1)) {
    const std::size_t after = at + marker_.size();
    if (after < data_.size() && (data_[after] == '\r' || data_[after] == '\n')) return at;
  }
  return none;
}

bool Multipart::skip_head() {
  const std::size_t start = find_marker(0);
  if (start == none) {
    data_.erase(0, data_.size() - std::min(data_.size(), marker_.size()));
    return false;
  }
  const std::size_t end = end_of_head(data_, start);
  if (end == none) {
    if (data_.size() - start > longest_head) data_.erase(0, start + marker_.size());
    return false;
  }
  length_ = content_length(data_.substr(start, end - start));
  data_.erase(0, end);
  is_in_body_ = true;
  searched_ = 0;
  return true;
}

std::optional<std::size_t> Multipart::end_of_body() {
  const std::size_t marker = find_marker(searched_);
  if (marker < length_.value_or(data_.size())) return marker;
  searched_ = data_.size() - std::min(data_.size(), marker_.size());
  if (length_) return data_.size() >= *length_ ? length_ : std::nullopt;
  const std::size_t end = data_.find_last_not_of("\r\n") + 1;
  const bool is_at_end = end >= 2 && data_.compare(end - 2, 2, jpeg_end) == 0;
  return is_at_end ? std::optional(end) : std::nullopt;
}

std::string Chunks::decoded(std::string_view bytes) {
  std::string content;
  while (!bytes.empty() && !is_over_) {
    if (left_ > 0) {
      const std::size_t n = std::min(left_, bytes.size());
      content += bytes.substr(0, n);
      bytes.remove_prefix(n);
      left_ -= n;
      continue;
    }
    const char c = bytes.front();
    bytes.remove_prefix(1);
    if (c == '\n') {
      begin_chunk();
    } else if (c != '\r') {
      line_ += c;
    }
    if (line_.size() > longest_size_line) throw std::invalid_argument("no size of a chunk");
  }
  return content;
}

void Chunks::begin_chunk() {
  if (line_.empty()) return;  // the end of the chunk before
  const auto read = std::from_chars(line_.data(), line_.data() + line_.size(), left_, 16);
  if (read.ec != std::errc()) throw std::invalid_argument("no size of a chunk");
  is_over_ = left_ == 0;
  line_.clear();
}

}  // namespace robsim
