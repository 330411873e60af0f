#include "robsim/lab/capture/image_stream.hpp"

#include "robsim/lab/capture/capture_device.hpp"

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

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "robsim/base/system.hpp"
#include "robsim/lab/capture/multipart.hpp"
#include "robsim/lab/capture/whole_jpeg.hpp"

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
