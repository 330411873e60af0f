#include "robsim/simulation/remote/message_socket.hpp"

#ifdef _WIN32

namespace robsim {

MessageSocket::MessageSocket(int, Limits, std::function<void()>) {
  throw std::runtime_error("sockets like these are made for Linux and macOS");
}
void MessageSocket::send(std::uint16_t, const std::vector<std::string_view>&, double) {}
MessageSocket::Message MessageSocket::receive(double) { return {}; }

}  // namespace robsim

#else

#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <system_error>
#include <utility>

#include "robsim/base/system.hpp"

namespace robsim {

namespace {

// A reader that is gone is an error of the call, never a signal.
#ifdef MSG_NOSIGNAL
constexpr int not_blocking = MSG_DONTWAIT | MSG_NOSIGNAL;
#else
constexpr int not_blocking = MSG_DONTWAIT;
#endif

constexpr std::size_t buffer_bytes = 1 << 16;
constexpr double longest_poll = 0.2;  // s: a signal that comes just before a wait does not end it

bool is_for_later(int error) { return error == EAGAIN || error == EWOULDBLOCK; }

[[noreturn]] void throw_error(int error) {
  if (error == EPIPE || error == ECONNRESET) {
    throw ConnectionEnd("the other side has closed the connection");
  }
  throw std::system_error(error, std::generic_category());
}

iovec vector_of(std::string_view part) { return {const_cast<char*>(part.data()), part.size()}; }

}  // namespace

struct MessageSocket::Head {
  std::uint16_t kind = 0;
  std::uint16_t zero = 0;
  std::uint32_t length = 0;
};

MessageSocket::MessageSocket(int descriptor, Limits limits, std::function<void()> interrupted)
    : descriptor_(descriptor),
      limits_(std::move(limits)),
      interrupted_(std::move(interrupted)),
      buffer_(buffer_bytes) {}

void MessageSocket::send(std::uint16_t kind, const std::vector<std::string_view>& parts,
                         double patience) {
  const double deadline = monotonic_now() + patience;
  Head head{kind, 0, 0};
  std::vector<iovec> left{{&head, sizeof head}};
  std::size_t length = 0;
  for (const std::string_view part : parts) {
    length += part.size();
    left.push_back(vector_of(part));
  }
  head.length = static_cast<std::uint32_t>(length);
  auto next = left.begin();
  while (next != left.end()) {
    msghdr message{};
    message.msg_iov = &*next;
    message.msg_iovlen = static_cast<decltype(message.msg_iovlen)>(left.end() - next);
    ssize_t sent = ::sendmsg(descriptor_, &message, not_blocking);
    if (sent < 0) {
      const int error = errno;
      if (error == EINTR)
        interrupted_();
      else if (is_for_later(error))
        wait_for(POLLOUT, deadline);
      else
        throw_error(error);
      continue;
    }
    for (; next != left.end() && static_cast<std::size_t>(sent) >= next->iov_len; ++next) {
      sent -= static_cast<ssize_t>(next->iov_len);
    }
    if (next == left.end()) break;
    next->iov_base = static_cast<char*>(next->iov_base) + sent;
    next->iov_len -= static_cast<std::size_t>(sent);
  }
}

MessageSocket::Message MessageSocket::receive(double patience) {
  const double deadline = monotonic_now() + patience;
  std::size_t have = 0;
  while (have < sizeof(Head)) {
    have += receive_some(buffer_.data() + have, buffer_.size() - have, deadline, have);
  }
  const Head head = this->head();
  const std::size_t length = head.length;
  const std::size_t here = have - sizeof(Head);  // of the body
  const char* const body = buffer_.data() + sizeof(Head);
  if (here > length) throw WrongMessage("more than one message at a time");
  if (here == length) return {head.kind, {body, length}};
  long_body_.resize(length);
  std::copy_n(body, here, long_body_.data());
  for (std::size_t at = here; at < length;) {
    at += receive_some(long_body_.data() + at, length - at, deadline, have);
  }
  return {head.kind, {long_body_.data(), length}};
}

MessageSocket::Head MessageSocket::head() const {
  Head head;
  std::memcpy(&head, buffer_.data(), sizeof head);
  if (head.zero != 0 || (limits_ && !limits_->count(head.kind))) {
    throw WrongMessage("a message of an unknown kind");
  }
  if (limits_ && head.length > limits_->at(head.kind)) {
    throw WrongMessage("a message of " + std::to_string(head.length) +
                       " bytes exceeds the limit of " + std::to_string(limits_->at(head.kind)));
  }
  return head;
}

// Some bytes more of a message of which there are `have`; at least one.
std::size_t MessageSocket::receive_some(char* to, std::size_t size, double deadline,
                                        std::size_t have) {
  while (true) {
    const ssize_t count = ::recv(descriptor_, to, size, not_blocking);
    if (count > 0) return static_cast<std::size_t>(count);
    if (count == 0) {
      throw ConnectionEnd(std::string("the other side has closed the connection") +
                          (have ? " in the middle of a message" : ""));
    }
    const int error = errno;
    if (error == EINTR)
      interrupted_();
    else if (!is_for_later(error))
      throw_error(error);
    else
      wait_for(POLLIN, deadline);
  }
}

// Until it can be read from, or written to, or a signal has come, or for `longest_poll`.
void MessageSocket::wait_for(short events, double deadline) const {
  const double left = deadline - monotonic_now();
  if (left <= 0) throw MessageTimeout("no whole message in time");
  pollfd waited{descriptor_, events, 0};
  const double milliseconds = std::ceil(1000 * std::min(left, longest_poll));
  const int ready = ::poll(&waited, 1, static_cast<int>(milliseconds));
  if (ready > 0) return;
  if (ready < 0 && errno != EINTR) throw_error(errno);
  interrupted_();
}

}  // namespace robsim

#endif
