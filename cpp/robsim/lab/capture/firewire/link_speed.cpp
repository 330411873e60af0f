#include "robsim/lab/capture/firewire/link_speed.hpp"

#ifdef __linux__

#include <fcntl.h>
#include <linux/firewire-cdev.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string>

#include "robsim/lab/capture/firewire/fire_wire_bus.hpp"

namespace robsim::fire_wire {

namespace {

constexpr std::uint32_t interface_version = 4;  // of Linux 2.6.36, which libdc1394 takes

// The number of a node, from its configuration ROM: IEEE 1212, 7.3.
std::optional<std::uint64_t> guid_of(int descriptor) {
  std::array<std::uint32_t, 5> rom{};
  fw_cdev_get_info info{};
  info.version = interface_version;
  info.rom = reinterpret_cast<std::uintptr_t>(rom.data());
  info.rom_length = sizeof rom;
  if (ioctl(descriptor, FW_CDEV_IOC_GET_INFO, &info) < 0) return {};
  if (info.rom_length < sizeof rom) return {};
  return std::uint64_t{rom[3]} << 32 | rom[4];
}

std::optional<dc1394speed_t> speed_of(int descriptor) {
  const int code = ioctl(descriptor, FW_CDEV_IOC_GET_SPEED, nullptr);
  if (code < 0) return {};
  return static_cast<dc1394speed_t>(std::min<int>(code, DC1394_ISO_SPEED_MAX));
}

}  // namespace

std::optional<dc1394speed_t> link_speed(std::uint64_t guid) {
  for (const std::string& path : nodes().readable) {
    const int descriptor = open(path.c_str(), O_RDWR | O_CLOEXEC);
    if (descriptor < 0) continue;
    const bool is_it = guid_of(descriptor) == guid;
    const std::optional<dc1394speed_t> speed = is_it ? speed_of(descriptor) : std::nullopt;
    close(descriptor);
    if (is_it) return speed;
  }
  return {};
}

}  // namespace robsim::fire_wire

#else

namespace robsim::fire_wire {

std::optional<dc1394speed_t> link_speed(std::uint64_t) { return {}; }

}  // namespace robsim::fire_wire

#endif
