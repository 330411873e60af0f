#include "robsim/lab/capture/image_stream.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "robsim/base/system.hpp"
#include "robsim/lab/capture/capture_device.hpp"

#ifndef _WIN32
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#endif

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

#ifdef _WIN32

namespace robsim {

// Nobody has tried it there.
struct ImageStream::State {};
ImageStream::ImageStream(int, std::string_view, std::string_view, bool, const std::string& name)
    : state_("the stream") {
  throw CaptureError(CaptureFault::no_back_end,
                     name + " is not read by back_end='http' on Windows: give back_end='ffmpeg'");
}
ImageStream::~ImageStream() = default;
std::optional<ImageStream::Taken> ImageStream::take(double) { return std::nullopt; }

}  // namespace robsim

#else

namespace robsim {

namespace {

constexpr std::size_t at_once = std::size_t{1} << 18;  // bytes

bool is_whole_image(const std::string& jpeg) {
  return is_whole_jpeg(reinterpret_cast<const std::uint8_t*>(jpeg.data()), jpeg.size());
}

}  // namespace

struct ImageStream::State {
  State(int descriptor, std::string_view boundary, std::string_view begun, bool is_chunked,
        const std::string& name);
  ~State();

  void run();
  void feed(std::string_view bytes);
  void keep(std::string jpeg, double arrived);

  const std::string name;
  const int descriptor;
  const bool is_chunked;
  // Of the thread:
  Chunks chunks;
  Multipart parts;

  std::mutex mutex;  // guards what follows
  std::condition_variable changed;
  std::optional<Taken> newest;
  std::string end;  // why the stream has ended; empty: it goes on
  std::thread thread;
};

ImageStream::State::State(int descriptor, std::string_view boundary, std::string_view begun,
                          bool is_chunked, const std::string& name)
    : name(name),
      descriptor(fcntl(descriptor, F_DUPFD_CLOEXEC, 0)),
      is_chunked(is_chunked),
      parts(boundary) {
  if (this->descriptor < 0) {
    throw CaptureError(CaptureFault::failed, name + ": " + std::generic_category().message(errno));
  }
  thread = start_thread([this, begun = std::string(begun)] {
    try {
      feed(begun);
      run();
    } catch (const std::exception& error) {
      const std::lock_guard lock(mutex);
      end = this->name + " broke off: " + error.what();
    }
    changed.notify_all();
  });
}

ImageStream::State::~State() {
  if (thread.joinable()) {
    shutdown(descriptor, SHUT_RDWR);  // ends a wait
    thread.join();
  }
  ::close(descriptor);
}

void ImageStream::State::run() {
  std::vector<char> bytes(at_once);
  while (true) {
    pollfd readable{descriptor, POLLIN, 0};
    poll(&readable, 1, -1);
    const ssize_t n = recv(descriptor, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (n < 0) throw std::system_error(errno, std::generic_category());
    if (n == 0) break;
    feed({bytes.data(), static_cast<std::size_t>(n)});
  }
  const std::lock_guard lock(mutex);
  end = name + " has ended the stream: is the camera off, or is another reader connected?";
}

void ImageStream::State::feed(std::string_view bytes) {
  const double arrived = monotonic_now();
  if (is_chunked) {
    parts.feed(chunks.decoded(bytes));
  } else {
    parts.feed(bytes);
  }
  while (auto part = parts.next()) keep(std::move(*part), arrived);
}

void ImageStream::State::keep(std::string jpeg, double arrived) {
  const bool is_kept = is_whole_image(jpeg);
  const std::lock_guard lock(mutex);
  if (!newest) newest.emplace();
  if (is_kept) {
    newest->passed += !newest->jpeg.empty();
    newest->jpeg = std::move(jpeg);
    newest->arrived = arrived;
  } else {
    ++newest->torn;
  }
  changed.notify_all();
}

ImageStream::ImageStream(int descriptor, std::string_view boundary, std::string_view begun,
                         bool is_chunked, const std::string& name)
    : state_("the stream", descriptor, boundary, begun, is_chunked, name) {}

ImageStream::~ImageStream() = default;

std::optional<ImageStream::Taken> ImageStream::take(double timeout) {
  State& state = *state_.operator->();
  std::unique_lock lock(state.mutex);
  state.changed.wait_for(lock, std::chrono::duration<double>(timeout),
                         [&] { return state.newest || !state.end.empty(); });
  if (state.newest) return std::exchange(state.newest, std::nullopt);
  if (!state.end.empty()) throw CaptureError(CaptureFault::unplugged, state.end);
  return std::nullopt;
}

}  // namespace robsim

#endif
