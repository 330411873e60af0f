#include "robsim/lab/capture/pixel_stream.hpp"

#include <cerrno>
#include <cmath>
#include <utility>

#include "robsim/base/system.hpp"

#ifndef _WIN32
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#endif

namespace robsim {

namespace {

constexpr double patience_for_frame = 0.1;      // s
constexpr std::uint32_t most_bytes = 3u << 28;  // of a frame: 16384 x 16384 px

}  // namespace

#ifdef _WIN32

PixelStream::PixelStream(int, std::string name) : descriptor_(-1), name_(std::move(name)) {
  throw CaptureError(CaptureFault::no_back_end, name_ + ": this system has no sockets of its kind");
}
PixelStream::~PixelStream() = default;
bool PixelStream::fill(std::uint8_t*, std::size_t, double) { return false; }

#else

PixelStream::PixelStream(int descriptor, std::string name)
    : descriptor_(fcntl(descriptor, F_DUPFD_CLOEXEC, 0)), name_(std::move(name)) {
  if (descriptor_ < 0) {
    throw CaptureError(CaptureFault::failed, name_ + ": no more files can be opened");
  }
}

PixelStream::~PixelStream() { ::close(descriptor_); }

// Goes on where it stopped; false if not all has come by the deadline.
bool PixelStream::fill(std::uint8_t* to, std::size_t size, double deadline) {
  while (filled_ < size) {
    pollfd ready{descriptor_, POLLIN, 0};
    const double left = deadline - monotonic_now();
    if (left <= 0) return false;
    if (poll(&ready, 1, static_cast<int>(std::ceil(1000 * left))) == 0) return false;
    const ssize_t received = recv(descriptor_, to + filled_, size - filled_, MSG_DONTWAIT);
    if (received > 0) {
      filled_ += static_cast<std::size_t>(received);
    } else if (received == 0 || (errno != EAGAIN && errno != EINTR)) {
      throw CaptureError(CaptureFault::unplugged,
                         name_ + " delivers no more: the process that read it has ended");
    }
  }
  filled_ = 0;
  return true;
}

#endif

std::optional<Captured> PixelStream::next(ImagePool& pool) {
  const double deadline = monotonic_now() + patience_for_frame;
  if (!has_head_) {
    if (!fill(reinterpret_cast<std::uint8_t*>(&head_), sizeof head_, deadline)) return std::nullopt;
    if (head_.length > most_bytes) {
      throw CaptureError(CaptureFault::failed, name_ + " delivers frames that are too large");
    }
    body_.resize(head_.length);
    has_head_ = true;
  }
  if (!fill(body_.data(), body_.size(), deadline)) return std::nullopt;
  has_head_ = false;
  if (head_.kind == fault) tell_fault();
  if (head_.kind == opened) return std::nullopt;
  return captured(pool);
}

Captured PixelStream::captured(ImagePool& pool) const {
  Captured captured;
  captured.arrived = head_.arrived;
  if (!std::isnan(head_.exposed)) captured.exposed = head_.exposed;
  captured.passed = head_.passed;
  captured.torn = head_.torn;
  captured.is_complete = head_.kind == bgr;
  if (!captured.is_complete) return captured;
  const std::uint64_t expected = std::uint64_t{3} * head_.width * head_.height;
  if (expected == 0 || expected != head_.length) {
    throw CaptureError(CaptureFault::failed, name_ + " delivers frames of another size");
  }
  const auto width = static_cast<int>(head_.width), height = static_cast<int>(head_.height);
  const ImageView view{body_.data(), width, height, std::ptrdiff_t{3} * width};
  captured.image = pool.take(width, height);
  copy_bgr(view, captured.image.writable_view());
  return captured;
}

// The name of the fault, a line break, the message.
void PixelStream::tell_fault() const {
  const std::string text(body_.begin(), body_.end());
  const std::size_t end = text.find('\n');
  throw CaptureError(fault_of(text.substr(0, end)),
                     end == std::string::npos ? text : text.substr(end + 1));
}

}  // namespace robsim
