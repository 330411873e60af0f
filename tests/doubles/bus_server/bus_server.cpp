#include "bus_server/bus_server.hpp"

#include <fcntl.h>
#include <linux/futex.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <new>
#include <stdexcept>
#include <thread>
#include <utility>

#include "robsim/base/system.hpp"
#include "virtual_bus/bus_memory.hpp"

namespace robsim {

namespace {

using namespace virtual_bus;

constexpr std::uint64_t first_guid = 0x00B0'5A00'0000'0001;
constexpr std::size_t page = 4096;
constexpr double pause_unplugged = 0.05;  // s, between attempts to open the device again
constexpr std::size_t send_register = 0x614 / 4;

constexpr std::array<std::pair<const char*, Coding>, 7> codings{{{"mono8", Coding::mono8},
                                                                 {"yuv411", Coding::yuv411},
                                                                 {"yuv422", Coding::yuv422},
                                                                 {"yuv444", Coding::yuv444},
                                                                 {"rgb8", Coding::rgb8},
                                                                 {"mono16", Coding::mono16},
                                                                 {"raw8", Coding::raw8}}};
constexpr std::array<const char*, 4> filters{"rggb", "gbrg", "grbg", "bggr"};  // in IIDC's order

std::uint32_t bits_of(const std::vector<std::string>& names) {
  std::uint32_t bits = 0;
  for (const std::string& name : names) {
    const auto* const found = std::find_if(
        codings.begin(), codings.end(), [&](const auto& coding) { return name == coding.first; });
    if (found == codings.end()) throw std::invalid_argument("there is no coding " + name);
    bits |= 1u << static_cast<std::uint32_t>(found->second);
  }
  return bits;
}

std::uint32_t number_of_filter(const std::string& name) {
  const auto* const found = std::find(filters.begin(), filters.end(), name);
  if (found == filters.end()) throw std::invalid_argument("there is no colour filter " + name);
  return static_cast<std::uint32_t>(found - filters.begin());
}

void check(const BusCameraOptions& camera) {
  // So that it has a region of whole units: see iidc_registers.cpp.
  if (camera.width < 16 || camera.height < 16 || camera.width % 8 || camera.height % 2 ||
      camera.width > 4096 || camera.height > 4096) {
    throw std::invalid_argument(
        "a camera on FireWire must have a width of 16, 24 .. 4096 px and an even height of 16 .. "
        "4096 px, got " +
        std::to_string(camera.width) + " x " + std::to_string(camera.height) + " px");
  }
  if (camera.codings.empty()) throw std::invalid_argument("a camera must have a coding");
}

std::size_t picture_bytes(const BusCameraOptions& camera) {
  return std::size_t{3} * static_cast<std::size_t>(camera.width) *
         static_cast<std::size_t>(camera.height);
}

}  // namespace

struct BusServer::State {
  std::string path;
  std::size_t size = 0;
  BusMemory* bus = nullptr;
  std::vector<std::shared_ptr<CaptureDevice>> devices;
  std::array<std::atomic<bool>, most_cameras> is_held{};  // unplugged until it is plugged in again
  std::atomic<bool> stops{false};
  std::vector<std::thread> threads;

  CameraState& camera(int number) {
    if (number < 0 || number >= bus->n_cameras) {
      throw std::invalid_argument("camera must be 0 .. " + std::to_string(bus->n_cameras - 1) +
                                  ", got " + std::to_string(number));
    }
    return bus->cameras[static_cast<std::size_t>(number)];
  }

  void make(const std::vector<BusCameraOptions>& cameras, bool card_is_fast);
  void fill(const std::vector<BusCameraOptions>& cameras);
  void pump(std::size_t index);
  void deliver(std::size_t index);
  void write(CameraState& camera, const Captured& captured);
  void set_plugged_in(CameraState& camera, bool is_plugged_in);
};

void BusServer::State::make(const std::vector<BusCameraOptions>& cameras, bool card_is_fast) {
  size = (sizeof(BusMemory) + page - 1) / page * page;
  for (const BusCameraOptions& camera : cameras) size += n_slots * picture_bytes(camera);
  const int descriptor = open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor < 0) throw std::runtime_error(path + ": " + std::strerror(errno));
  void* memory = MAP_FAILED;
  if (posix_fallocate(descriptor, 0, static_cast<off_t>(size)) == 0) {
    memory = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  }
  ::close(descriptor);
  if (memory == MAP_FAILED) {
    unlink(path.c_str());
    throw std::runtime_error(path + ": there is no room for the pictures of the bus");
  }
  bus = new (memory) BusMemory;
  bus->card_speed = card_is_fast ? 3 : 2;
  fill(cameras);
}

void BusServer::State::fill(const std::vector<BusCameraOptions>& cameras) {
  pthread_mutexattr_t shared;
  pthread_mutexattr_init(&shared);
  pthread_mutexattr_setpshared(&shared, PTHREAD_PROCESS_SHARED);
  pthread_mutexattr_setrobust(&shared, PTHREAD_MUTEX_ROBUST);
  pthread_mutex_init(&bus->lock, &shared);
  pthread_mutexattr_destroy(&shared);
  std::size_t pixels = (sizeof(BusMemory) + page - 1) / page * page;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    CameraState& camera = bus->cameras[i];
    camera.width = cameras[i].width;
    camera.height = cameras[i].height;
    camera.fps = cameras[i].fps;
    camera.guid = first_guid + i;
    camera.codings = bits_of(cameras[i].codings);
    camera.color_filter = number_of_filter(cameras[i].color_filter);
    camera.speed = cameras[i].is_fast ? 3 : 2;
    camera.pixels = pixels;
    camera.is_plugged_in = true;  // a program that starts at once finds it
    pixels += n_slots * picture_bytes(cameras[i]);
  }
  bus->n_cameras = static_cast<int>(cameras.size());
  bus->size = size;
  bus->magic = bus_magic;
}

void BusServer::State::set_plugged_in(CameraState& camera, bool is_plugged_in) {
  if (camera.is_plugged_in == is_plugged_in) return;
  {
    const BusLock lock(*bus);
    camera.is_on = false;  // it starts anew
    camera.is_plugged_in = is_plugged_in;
  }
  ++bus->generation;
}

void BusServer::State::write(CameraState& camera, const Captured& captured) {
  const ImageView seen = captured.image.view();
  if (seen.width != camera.width || seen.height != camera.height) return;
  const std::uint32_t number = camera.n_pictures;
  const double time = captured.exposed.value_or(captured.arrived);
  camera.exposed[number % n_slots] = std::llround(time * 1e9);
  copy(seen,
       {bus->picture(camera, number), seen.width, seen.height, std::ptrdiff_t{3} * seen.width});
  camera.n_pictures = number + 1;
  syscall(SYS_futex, &camera.n_pictures, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
}

// Until it is unplugged: CaptureError.
void BusServer::State::deliver(std::size_t index) {
  ImagePool pool;
  CameraState& camera = bus->cameras[index];
  devices[index]->open();
  while (!stops) {
    set_plugged_in(camera, !is_held[index]);
    const std::optional<Captured> captured = devices[index]->next(pool);
    if (captured && captured->is_complete) write(camera, *captured);
  }
}

void BusServer::State::pump(std::size_t index) {
  while (!stops) {
    try {
      deliver(index);
    } catch (const std::exception&) {
      set_plugged_in(bus->cameras[index], false);
    }
    devices[index]->close();
    if (!stops) sleep_until(monotonic_now() + pause_unplugged);
  }
}

BusServer::BusServer(const std::string& path, const std::vector<BusCameraOptions>& cameras,
                     std::vector<std::shared_ptr<CaptureDevice>> devices, bool card_is_fast)
    : state_(std::make_unique<State>()) {
  if (cameras.empty() || cameras.size() > most_cameras || cameras.size() != devices.size()) {
    throw std::invalid_argument("a bus must have 1 .. " + std::to_string(most_cameras) +
                                " cameras");
  }
  for (const BusCameraOptions& camera : cameras) {
    check(camera);
    bits_of(camera.codings);
    number_of_filter(camera.color_filter);
  }
  state_->path = path;
  state_->devices = std::move(devices);
  state_->make(cameras, card_is_fast);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    state_->threads.push_back(start_thread([state = state_.get(), i] { state->pump(i); }));
  }
}

BusServer::~BusServer() {
  close();
  if (state_->bus) munmap(state_->bus, state_->size);
}

void BusServer::close() noexcept {
  state_->stops = true;
  for (const auto& device : state_->devices) device->interrupt();
  for (std::thread& thread : state_->threads) {
    if (thread.joinable()) thread.join();
  }
  for (int i = 0; i < state_->bus->n_cameras; ++i) {
    state_->set_plugged_in(state_->bus->cameras[static_cast<std::size_t>(i)], false);
  }
  unlink(state_->path.c_str());
}

std::string BusServer::guid_of(int camera) const {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx",
                static_cast<unsigned long long>(state_->camera(camera).guid));
  return text.data();
}

void BusServer::unplug(int camera) {
  CameraState& state = state_->camera(camera);
  state_->is_held[static_cast<std::size_t>(camera)] = true;
  state_->set_plugged_in(state, false);
}

void BusServer::plug_in(int camera) {
  state_->camera(camera);
  state_->is_held[static_cast<std::size_t>(camera)] = false;
}

void BusServer::stall(double seconds, int camera) {
  state_->camera(camera).silent_until = std::llround((monotonic_now() + seconds) * 1e9);
}

void BusServer::deny(int camera, bool is_denied) { state_->camera(camera).is_denied = is_denied; }

void BusServer::simplify(int camera) { state_->camera(camera).is_plain = true; }

void BusServer::shorten(int camera, bool is_short) { state_->camera(camera).is_short = is_short; }

void BusServer::reset(bool power_fails) {
  if (power_fails) {
    const BusLock lock(*state_->bus);
    for (CameraState& camera : state_->bus->cameras) camera.control[send_register] = 0;
  }
  ++state_->bus->generation;
}

void BusServer::refuse(bool channels, bool bandwidth) {
  state_->bus->refuses_channels = channels;
  state_->bus->refuses_bandwidth = bandwidth;
}

std::int64_t BusServer::lost_frames(int camera) const { return state_->camera(camera).n_lost; }

bool BusServer::is_sending(int camera) const {
  CameraState& state = state_->camera(camera);
  const BusLock lock(*state_->bus);
  return state.control[send_register] >> 31;
}

}  // namespace robsim
