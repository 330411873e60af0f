// Discovery of the GigE Vision Control Protocol (GVCP): one datagram asks, each camera answers with
// its first registers.
#include "robsim/lab/capture/gige/gige_vision.hpp"

#include <arpa/inet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <ifaddrs.h>
#include <netdb.h>
#include <poll.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

#include "robsim/base/system.hpp"

namespace robsim {

namespace {

constexpr std::size_t header_size = 8, registers_size = 0xf8;  // bytes
constexpr double interval = 0.1;                               // s between two questions
using Answer = std::array<std::uint8_t, header_size + registers_size>;

// Key 0x42, acknowledgement wanted, discovery (2), no payload, number of the request.
constexpr std::uint8_t question_id = 0x17;
constexpr std::array<std::uint8_t, header_size> question{0x42, 0x01, 0, 2, 0, 0, 0, question_id};

class Socket {
 public:
  Socket() : descriptor_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}
  ~Socket() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  Socket(Socket&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

std::string text_of(const in_addr& address) {
  std::array<char, INET_ADDRSTRLEN> text{};
  inet_ntop(AF_INET, &address, text.data(), text.size());
  return text.data();
}

sockaddr_in gvcp_at(const in_addr& address) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(gvcp_port);
  to.sin_addr = address;
  return to;
}

std::optional<in_addr> resolved(const std::string& host) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), nullptr, &hints, &found) != 0 || !found) return std::nullopt;
  const in_addr address = reinterpret_cast<const sockaddr_in*>(found->ai_addr)->sin_addr;
  freeaddrinfo(found);
  return address;
}

std::string string_at(const Answer& answer, std::size_t offset, std::size_t length) {
  const auto* from = reinterpret_cast<const char*>(answer.data()) + header_size + offset;
  return {from, strnlen(from, length)};
}

// Addresses of the registers: GigE Vision, bootstrap registers.
std::optional<GigeIdentity> identity_of(const Answer& answer, ssize_t size) {
  const bool is_answer = size == static_cast<ssize_t>(answer.size()) && answer[2] == 0 &&
                         answer[3] == 3 && answer[7] == question_id;
  if (!is_answer) return std::nullopt;
  GigeIdentity identity;
  in_addr address{};
  std::memcpy(&address, answer.data() + header_size + 0x24, sizeof address);
  identity.address = text_of(address);
  identity.vendor = string_at(answer, 0x48, 32);
  identity.model = string_at(answer, 0x68, 32);
  identity.serial = string_at(answer, 0xd8, 16);
  identity.user_name = string_at(answer, 0xe8, 16);
  return identity;
}

bool wait_for_any(std::vector<pollfd>& sockets, double seconds) {
  const int milliseconds = static_cast<int>(std::ceil(1000 * std::max(seconds, 0.0)));
  return poll(sockets.data(), sockets.size(), milliseconds) > 0;
}

struct Network {
  Socket socket;
  in_addr address{};
  std::vector<in_addr> targets;
};

std::vector<Network> networks() {
  std::vector<Network> list;
  ifaddrs* interfaces = nullptr;
  if (getifaddrs(&interfaces) != 0) return list;
  for (const ifaddrs* one = interfaces; one; one = one->ifa_next) {
    const bool is_up = one->ifa_flags & IFF_UP;
    if (!is_up || !one->ifa_addr || one->ifa_addr->sa_family != AF_INET) continue;
    Network network;
    network.address = reinterpret_cast<const sockaddr_in*>(one->ifa_addr)->sin_addr;
    in_addr everybody{};
    everybody.s_addr = INADDR_BROADCAST;
    network.targets = {everybody, network.address};  // what is served here hears no broadcast
    if ((one->ifa_flags & IFF_BROADCAST) && one->ifa_broadaddr) {
      network.targets.push_back(reinterpret_cast<const sockaddr_in*>(one->ifa_broadaddr)->sin_addr);
    }
    sockaddr_in from{};
    from.sin_family = AF_INET;
    from.sin_addr = network.address;
    const int on = 1;
    const int descriptor = network.socket.get();
    setsockopt(descriptor, SOL_SOCKET, SO_BROADCAST, &on, sizeof on);
    if (bind(descriptor, reinterpret_cast<const sockaddr*>(&from), sizeof from) == 0) {
      list.push_back(std::move(network));
    }
  }
  freeifaddrs(interfaces);
  return list;
}

void add(std::vector<GigeIdentity>& found, GigeIdentity identity) {
  const bool is_known = std::any_of(found.begin(), found.end(), [&](const GigeIdentity& other) {
    return other.address == identity.address && other.serial == identity.serial;
  });
  if (!is_known) found.push_back(std::move(identity));
}

}  // namespace

bool is_ipv4_address(const std::string& text) {
  in_addr address{};
  return inet_pton(AF_INET, text.c_str(), &address) == 1;
}

std::optional<GigeIdentity> ask_gige_camera(const std::string& host, double patience) {
  const std::optional<in_addr> address = resolved(host);
  const Socket socket;
  if (!address) return std::nullopt;
  const sockaddr_in to = gvcp_at(*address);
  if (connect(socket.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
    return std::nullopt;
  }
  const double end = monotonic_now() + patience;
  for (double now = monotonic_now(); now < end; now = monotonic_now()) {
    // Where nobody listens, the second send or the receive is refused: later somebody may.
    if (send(socket.get(), question.data(), question.size(), 0) < 0) return std::nullopt;
    std::vector<pollfd> ready{{socket.get(), POLLIN, 0}};
    if (!wait_for_any(ready, std::min(interval, end - now))) continue;
    Answer answer{};
    const ssize_t size = recv(socket.get(), answer.data(), answer.size(), MSG_DONTWAIT);
    if (size < 0) return std::nullopt;
    if (std::optional<GigeIdentity> identity = identity_of(answer, size)) {
      sockaddr_in own{};
      socklen_t length = sizeof own;
      getsockname(socket.get(), reinterpret_cast<sockaddr*>(&own), &length);
      identity->interface_address = text_of(own.sin_addr);
      identity->address = text_of(*address);
      return identity;
    }
  }
  return std::nullopt;
}

std::vector<GigeIdentity> find_gige_cameras(double seconds) {
  const std::vector<Network> list = networks();
  std::vector<pollfd> ready;
  for (const Network& network : list) {
    for (const in_addr& target : network.targets) {
      const sockaddr_in to = gvcp_at(target);
      static_cast<void>(sendto(network.socket.get(), question.data(), question.size(), 0,
                               reinterpret_cast<const sockaddr*>(&to), sizeof to));
    }
    ready.push_back({network.socket.get(), POLLIN, 0});
  }
  std::vector<GigeIdentity> found;
  const double end = monotonic_now() + seconds;
  while (monotonic_now() < end && wait_for_any(ready, end - monotonic_now())) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (!ready[i].revents) continue;
      Answer answer{};
      const ssize_t size = recv(ready[i].fd, answer.data(), answer.size(), MSG_DONTWAIT);
      if (std::optional<GigeIdentity> identity = identity_of(answer, size)) {
        identity->interface_address = text_of(list[i].address);
        add(found, *identity);
      }
    }
  }
  return found;
}

}  // namespace robsim
