#include "robsim/lab/motors/line.hpp"

#ifdef _WIN32

namespace robsim {

// Nobody has tried them there.
namespace {
[[noreturn]] void refuse() {
  throw LineError(
      "lines to robots are made for Linux and macOS: on Windows, use the Windows "
      "Subsystem for Linux, or send the inputs with a function of your own");
}
}  // namespace

Line Line::udp_to(const std::string&, int) { refuse(); }
Line Line::udp_at(const std::string&, int) { refuse(); }
Line Line::of_descriptor(int, const std::string&) { refuse(); }
Line::Line(Line&&) noexcept = default;
Line::~Line() = default;
void Line::close() {}
void Line::write(std::string_view, double) { refuse(); }
std::optional<Line::Piece> Line::read() { refuse(); }
void Line::wait(const Wake&, double) const { refuse(); }
Line::Wake::Wake() { refuse(); }
Line::Wake::~Wake() = default;
void Line::Wake::ring() const {}

}  // namespace robsim

#else

#include <arpa/inet.h>
#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <memory>
#include <system_error>
#include <utility>

#include "robsim/base/system.hpp"

namespace robsim {

namespace {

// A reader that is gone is an error of the write, never a signal.
#ifdef MSG_NOSIGNAL
constexpr int no_signal = MSG_NOSIGNAL;
#else
constexpr int no_signal = 0;
#endif

bool may_come_later(int error) { return error == EAGAIN || error == EWOULDBLOCK || error == EINTR; }

void make_non_blocking(int descriptor) {
  fcntl(descriptor, F_SETFD, FD_CLOEXEC);
  fcntl(descriptor, F_SETFL, fcntl(descriptor, F_GETFL) | O_NONBLOCK);
}

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

Addresses addresses_of(const std::string& host, int port, const std::string& name) {
  addrinfo wanted{};
  wanted.ai_family = AF_UNSPEC;
  wanted.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wanted, &found);
  if (error) throw LineError(name + ": there is no such host: " + gai_strerror(error));
  return {found, &freeaddrinfo};
}

int opened_socket(const addrinfo& address, const std::string& name) {
  const int descriptor = socket(address.ai_family, SOCK_DGRAM, 0);
  if (descriptor < 0) {
    throw LineError(name + " cannot be opened: " + std::generic_category().message(errno));
  }
  return descriptor;
}

bool is_hung_up(int descriptor) {
  pollfd end{descriptor, POLLIN, 0};
  poll(&end, 1, 0);
  return end.revents & (POLLHUP | POLLERR | POLLNVAL);
}

int port_of(int descriptor) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.ss_family == AF_INET6
                   ? reinterpret_cast<const sockaddr_in6&>(address).sin6_port
                   : reinterpret_cast<const sockaddr_in&>(address).sin_port);
}

std::string udp_name(const std::string& host, int port) {
  const bool is_ipv6 = host.find(':') != std::string::npos;
  return "UDP " + (is_ipv6 ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

std::string remedy(int error) {
  if (error == ECONNREFUSED) return ": nothing listens there; is the robot on, its port right?";
  if (error == EADDRINUSE) return ": another program listens there";
  if (error == EIO || error == ENXIO || error == ENODEV) return ": is the cable plugged in?";
  return "";
}

int milliseconds(double time) {
  return static_cast<int>(std::ceil(1000 * std::clamp(time, 0.0, 3600.0)));
}

}  // namespace

Line::Line(int descriptor, std::string name, bool is_socket)
    : descriptor_(descriptor), name_(std::move(name)), is_socket_(is_socket) {
  make_non_blocking(descriptor_);
}

Line::Line(Line&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      name_(std::move(other.name_)),
      is_socket_(other.is_socket_),
      is_listening_(other.is_listening_),
      is_deaf_(other.is_deaf_),
      is_broken_off_(other.is_broken_off_),
      port_(other.port_),
      peer_(std::move(other.peer_)) {}

Line::~Line() { close(); }

void Line::close() {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
}

Line Line::udp_to(const std::string& host, int port) {
  const std::string name = udp_name(host, port);
  const Addresses address = addresses_of(host, port, name);
  Line line(opened_socket(*address, name), name, true);
  // Connected: the system then tells that nobody listens.
  if (connect(line.descriptor_, address->ai_addr, address->ai_addrlen)) {
    line.fail("cannot be opened", errno);
  }
  return line;
}

Line Line::udp_at(const std::string& host, int port) {
  const std::string name = udp_name(host, port);
  const Addresses address = addresses_of(host, port, name);
  Line line(opened_socket(*address, name), name, true);
  if (bind(line.descriptor_, address->ai_addr, address->ai_addrlen)) {
    line.fail("cannot be opened", errno);
  }
  line.is_listening_ = true;
  line.port_ = port_of(line.descriptor_);
  line.name_ = udp_name(host, line.port_);
  return line;
}

Line Line::of_descriptor(int descriptor, const std::string& name) {
  const int own = fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
  if (own < 0) {
    throw LineError(name + ": " + std::to_string(descriptor) +
                    " is no open file descriptor: " + std::generic_category().message(errno));
  }
  Line line(own, name, false);
  line.is_deaf_ = (fcntl(own, F_GETFL) & O_ACCMODE) == O_WRONLY;
  return line;
}

void Line::fail(const char* what, int error) const {
  throw LineError(name_ + " " + what + ": " + std::generic_category().message(error) +
                  remedy(error));
}

bool Line::write_some(std::string_view& text) {
  ssize_t n = 0;
  if (is_listening_) {
    if (peer_.empty()) return true;  // nobody was heard yet
    n = sendto(descriptor_, text.data(), text.size(), no_signal,
               reinterpret_cast<const sockaddr*>(peer_.data()),
               static_cast<socklen_t>(peer_.size()));
  } else if (is_socket_) {
    n = ::send(descriptor_, text.data(), text.size(), no_signal);
  } else {
    n = ::write(descriptor_, text.data(), text.size());
  }
  if (n < 0 && !may_come_later(errno)) fail("cannot be written to", errno);
  if (n > 0) text.remove_prefix(static_cast<std::size_t>(n));
  return text.empty();
}

void Line::write(std::string_view text, double patience) {
  const double deadline = monotonic_now() + patience;
  // A line that was broken off ends here, so that it takes no other one with it.
  const std::string whole = (is_broken_off_ ? "\n" : "") + std::string(text);
  std::string_view left = whole;
  while (!write_some(left)) {
    is_broken_off_ = is_broken_off_ || left.size() < whole.size();
    const double time = deadline - monotonic_now();
    if (time <= 0) {
      throw LineError(name_ + " took no line within " + to_text(1000 * patience) +
                      " ms: does nobody read at its other end?");
    }
    pollfd writable{descriptor_, POLLOUT, 0};
    poll(&writable, 1, milliseconds(time));
  }
  is_broken_off_ = false;
}

std::optional<Line::Piece> Line::read() {
  if (is_deaf_) return std::nullopt;
  char bytes[2048];
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  const ssize_t n = is_socket_ ? recvfrom(descriptor_, bytes, sizeof(bytes), 0,
                                          reinterpret_cast<sockaddr*>(&address), &size)
                               : ::read(descriptor_, bytes, sizeof(bytes));
  if (n < 0 && may_come_later(errno)) return std::nullopt;
  // A terminal may say 0 where nothing has come.
  if (n == 0 && !is_socket_ && !is_hung_up(descriptor_)) return std::nullopt;
  is_deaf_ = !is_socket_ && n <= 0;  // otherwise each wait would end at once
  if (n < 0) fail("is cut", errno);
  if (is_deaf_) throw LineError(name_ + " is closed at its other end");
  Piece piece;
  piece.bytes.assign(bytes, static_cast<std::size_t>(n));
  piece.is_whole = is_socket_;
  if (is_listening_) {
    peer_.assign(reinterpret_cast<const char*>(&address), size);
    piece.source = peer_;
  }
  return piece;
}

void Line::wait(const Wake& wake, double time) const {
  pollfd ends[2] = {{wake.ends_[0], POLLIN, 0}, {descriptor_, POLLIN, 0}};
  poll(ends, is_deaf_ ? 1 : 2, milliseconds(time));
  char rung[64];
  while (::read(wake.ends_[0], rung, sizeof(rung)) > 0) {
  }
}

Line::Wake::Wake() {
  if (pipe(ends_)) throw LineError("no pipe: " + std::generic_category().message(errno));
  make_non_blocking(ends_[0]);
  make_non_blocking(ends_[1]);
}

Line::Wake::~Wake() {
  ::close(ends_[0]);
  ::close(ends_[1]);
}

void Line::Wake::ring() const {
  [[maybe_unused]] const ssize_t n = ::write(ends_[1], "!", 1);  // full: it rings already
}

}  // namespace robsim

#endif
