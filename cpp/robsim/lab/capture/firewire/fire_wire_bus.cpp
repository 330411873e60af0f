#include "robsim/lab/capture/firewire/fire_wire_bus.hpp"

#include <dirent.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <string>
#include <utility>

#ifdef __linux__
#include <fcntl.h>
#include <linux/firewire-cdev.h>
#include <sys/ioctl.h>
#endif

namespace robsim::fire_wire {

namespace {

using Library = std::unique_ptr<dc1394_t, decltype(&dc1394_free)>;
using Camera = std::unique_ptr<dc1394camera_t, decltype(&dc1394_camera_free)>;
using List = std::unique_ptr<dc1394camera_list_t, decltype(&dc1394_camera_free_list)>;

// What the library would write to standard error is in our messages, as far as it helps.
void be_silent() {
  static std::once_flag once;
  std::call_once(once, [] {
    dc1394_log_register_handler(DC1394_LOG_ERROR, nullptr, nullptr);
    dc1394_log_register_handler(DC1394_LOG_WARNING, nullptr, nullptr);
    dc1394_log_register_handler(DC1394_LOG_DEBUG, nullptr, nullptr);
  });
}

Library new_library() {
  be_silent();
  Library library(dc1394_new(), &dc1394_free);
  if (!library) throw CaptureError(CaptureFault::failed, "libdc1394 does not start");
  return library;
}

List list_of(dc1394_t* library) {
  dc1394camera_list_t* list = nullptr;
  check(dc1394_camera_enumerate(library, &list), "list the cameras");
  return {list, &dc1394_camera_free_list};
}

std::string text_of(std::uint64_t guid) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(guid));
  return text;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

// Why there is no camera: the library finds none in all of these cases.
[[noreturn]] void tell_why_none() {
  const Nodes found = nodes();
  if (!found.denied.empty()) {
    throw CaptureError(CaptureFault::no_permission,
                       "this user must not read " + joined(found.denied) +
                           ": ask for a rule of udev, or for the group that has FireWire (often "
                           "\"video\"): sudo usermod -aG video $USER, and log in anew");
  }
  if (found.readable.empty()) {
    throw CaptureError(CaptureFault::no_bus,
                       "there is no FireWire bus: this computer has no /dev/fw0, thus no FireWire "
                       "card, or its driver is missing (sudo modprobe firewire-ohci)");
  }
  throw CaptureError(CaptureFault::no_camera, "there is no camera on the FireWire bus (" +
                                                  joined(found.readable) +
                                                  "): is it plugged in, and has it power?");
}

std::uint64_t guid_of(dc1394_t* library, const std::string& choice) {
  const List list = list_of(library);
  if (list->num == 0) tell_why_none();
  std::vector<std::uint64_t> guids;
  for (std::uint32_t i = 0; i < list->num; ++i) guids.push_back(list->ids[i].guid);
  std::sort(guids.begin(), guids.end());
  if (choice.size() < 16) {
    const std::size_t number = choice.empty() ? 0 : std::stoul(choice);
    if (number < guids.size()) return guids[number];
  } else {
    const std::uint64_t guid = std::stoull(choice, nullptr, 16);
    if (std::count(guids.begin(), guids.end(), guid)) return guid;
  }
  std::vector<std::string> names;
  for (std::size_t i = 0; i < guids.size(); ++i) {
    names.push_back("firewire://" + std::to_string(i) + " (" + text_of(guids[i]) + ")");
  }
  throw CaptureError(
      CaptureFault::no_camera,
      "there is no camera " + choice + " on the FireWire bus; there are: " + joined(names));
}

}  // namespace

void check(dc1394error_t error, const std::string& action) {
  if (error == DC1394_SUCCESS) return;
  throw CaptureError(CaptureFault::failed,
                     "could not " + action + ": " + dc1394_error_get_string(error));
}

Nodes nodes() {
  Nodes found;
  DIR* const directory = opendir("/dev");
  if (!directory) return found;
  while (const dirent* entry = readdir(directory)) {
    const char* name = entry->d_name;
    if (std::strncmp(name, "fw", 2) != 0 || name[2] < '0' || name[2] > '9') continue;
    const std::string path = std::string("/dev/") + name;
    (access(path.c_str(), R_OK | W_OK) == 0 ? found.readable : found.denied).push_back(path);
  }
  closedir(directory);
  std::sort(found.readable.begin(), found.readable.end());
  std::sort(found.denied.begin(), found.denied.end());
  return found;
}

std::vector<FoundCamera> find_cameras() {
  const Library library = new_library();
  const List list = list_of(library.get());
  std::vector<FoundCamera> found;
  for (std::uint32_t i = 0; i < list->num; ++i) {
    const Camera camera(dc1394_camera_new_unit(library.get(), list->ids[i].guid, list->ids[i].unit),
                        &dc1394_camera_free);
    if (!camera) continue;
    found.push_back({text_of(camera->guid), camera->vendor ? camera->vendor : "",
                     camera->model ? camera->model : ""});
  }
  std::sort(found.begin(), found.end(),
            [](const FoundCamera& a, const FoundCamera& b) { return a.guid < b.guid; });
  return found;
}

CameraHandle::CameraHandle(const std::string& choice)
    : library_(new_library()), camera_(nullptr, &dc1394_camera_free) {
  const std::uint64_t guid = guid_of(library_.get(), choice);
  camera_.reset(dc1394_camera_new(library_.get(), guid));
  if (!camera_) {
    throw CaptureError(CaptureFault::unplugged, "the FireWire camera " + text_of(guid) +
                                                    " does not answer: plug it in again");
  }
}

std::string CameraHandle::guid() const { return text_of(camera_->guid); }

#ifdef __linux__

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

#else

std::optional<dc1394speed_t> link_speed(std::uint64_t) { return {}; }

#endif

}  // namespace robsim::fire_wire
