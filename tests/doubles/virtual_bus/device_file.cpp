#include "virtual_bus/device_file.hpp"

#include <arpa/inet.h>
#include <linux/firewire-cdev.h>
#include <linux/firewire-constants.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>

#include "virtual_bus/attached_bus.hpp"
#include "virtual_bus/iidc_registers.hpp"
#include "virtual_bus/iso_receiver.hpp"
#include "virtual_bus/system_calls.hpp"

namespace robsim::virtual_bus {

namespace {

constexpr std::uint64_t register_base = 0xFFFF'F000'0000;
constexpr std::uint32_t interface_version = 5;   // of Linux 3.4
constexpr std::uint32_t longest_request = 2048;  // bytes

template <typename T>
T* pointer(std::uint64_t address) {
  return reinterpret_cast<T*>(static_cast<std::uintptr_t>(address));
}

int next_number() {
  static std::atomic<int> number{0};
  return ++number;
}

// The kernel reads both at a time; here the thread may be held up in between, and looks again.
void read_both_clocks(fw_cdev_get_cycle_timer& timer) {
  constexpr std::int64_t soon = 50'000;  // ns
  std::int64_t before = 0, after = 0;
  timeval wall{};
  for (int i = 0; i == 0 || (i < 10 && after - before > soon); ++i) {
    before = now_ns();
    gettimeofday(&wall, nullptr);
    after = now_ns();
  }
  timer.cycle_timer = cycle_timer_at(after);
  timer.local_time = static_cast<std::uint64_t>(wall.tv_sec) * 1'000'000 +
                     static_cast<std::uint64_t>(wall.tv_usec);
}

bool is_running(int process) { return kill(process, 0) == 0 || errno == EPERM; }

}  // namespace

std::int64_t now_ns() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

std::uint32_t cycle_timer_at(std::int64_t ns) {
  const auto time = static_cast<std::uint64_t>(ns);
  const std::uint64_t seconds = time / 1'000'000'000 % 128;
  const std::uint64_t cycles = time % 1'000'000'000 / 125'000;
  const std::uint64_t rest = time % 125'000 * 3072 / 125'000;
  return static_cast<std::uint32_t>(seconds << 25 | cycles << 12 | rest);
}

EventQueue::~EventQueue() { hang_up(); }

void EventQueue::send(const void* event, std::size_t size) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (descriptor_ >= 0) ::send(descriptor_, event, size, MSG_DONTWAIT | MSG_NOSIGNAL);
}

void EventQueue::wait() { const std::lock_guard<std::mutex> lock(mutex_); }

void EventQueue::hang_up() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (descriptor_ >= 0) real_close(descriptor_);
  descriptor_ = -1;
}

DeviceFile::DeviceFile(BusMemory& bus, int node, int queue)
    : bus_(bus),
      node_(node),
      number_(next_number()),
      events_(std::make_shared<EventQueue>(queue)),
      told_generation_(bus.generation) {}

DeviceFile::~DeviceFile() {
  receiver_.reset();
  for (const auto& [handle, resource] : resources_) release(resource.index);
}

CameraState* DeviceFile::camera() const {
  return node_ == 0 ? nullptr : &bus_.cameras[static_cast<std::size_t>(node_ - 1)];
}

bool DeviceFile::is_alive() const { return is_there(bus_, node_); }

int DeviceFile::control(unsigned long request, void* argument) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!is_alive()) {
    events_->hang_up();
    return -ENODEV;
  }
  return request == FW_CDEV_IOC_GET_SPEED ? speed() : -perform(request, argument);
}

// Between the card and this node.
int DeviceFile::speed() const {
  const CameraState* const state = camera();
  return static_cast<int>(state ? std::min(state->speed, bus_.card_speed) : bus_.card_speed);
}

// 0, or the number of an error.
int DeviceFile::perform(unsigned long request, void* argument) {
  switch (request) {
    case FW_CDEV_IOC_GET_INFO:
      return get_info(argument);
    case FW_CDEV_IOC_SEND_REQUEST:
      return send_request(argument);
    case FW_CDEV_IOC_SEND_BROADCAST_REQUEST:
      return EACCES;
    case FW_CDEV_IOC_INITIATE_BUS_RESET:
      ++bus_.generation;
      return 0;
    case FW_CDEV_IOC_ALLOCATE_ISO_RESOURCE:
      return allocate(argument);
    case FW_CDEV_IOC_DEALLOCATE_ISO_RESOURCE:
      return deallocate(argument);
    case FW_CDEV_IOC_GET_CYCLE_TIMER: {
      auto* timer = static_cast<fw_cdev_get_cycle_timer*>(argument);
      read_both_clocks(*timer);
      return 0;
    }
    case FW_CDEV_IOC_CREATE_ISO_CONTEXT: {
      auto* create = static_cast<fw_cdev_create_iso_context*>(argument);
      if (receiver_) return EBUSY;
      if (!camera() || create->type != FW_CDEV_ISO_CONTEXT_RECEIVE) return EINVAL;
      receiver_ = std::make_unique<IsoReceiver>(bus_, events_, create->channel, create->header_size,
                                                create->closure);
      create->handle = 0;
      return 0;
    }
    case FW_CDEV_IOC_QUEUE_ISO:
      return receiver_ ? receiver_->queue(*static_cast<const fw_cdev_queue_iso*>(argument))
                       : EINVAL;
    case FW_CDEV_IOC_START_ISO:
      if (!receiver_) return EINVAL;
      receiver_->start();
      return 0;
    case FW_CDEV_IOC_STOP_ISO:
      if (!receiver_) return EINVAL;
      receiver_->stop();
      return 0;
    default:
      return ENOTTY;
  }
}

void DeviceFile::tell_of_reset(std::uint32_t generation) {
  fw_cdev_event_bus_reset event{};
  event.closure = reset_closure_;
  event.type = FW_CDEV_EVENT_BUS_RESET;
  event.node_id = 0xFFC0u | static_cast<unsigned>(node_);
  event.local_node_id = 0xFFC0;
  event.root_node_id = event.irm_node_id = event.bm_node_id = 0xFFC0;
  event.generation = generation;
  told_generation_ = generation;
  events_->send(&event, sizeof event);
}

int DeviceFile::get_info(void* argument) {
  auto* info = static_cast<fw_cdev_get_info*>(argument);
  const std::vector<std::uint32_t> rom =
      node_ ? config_rom_of(*camera()) : config_rom_of_computer();
  const std::size_t size = rom.size() * sizeof(std::uint32_t);
  if (info->rom) {
    std::memcpy(pointer<void>(info->rom), rom.data(),
                std::min<std::size_t>(info->rom_length, size));
  }
  info->rom_length = static_cast<std::uint32_t>(size);
  info->version = interface_version;
  info->card = 0;
  told_generation_ = bus_.generation;
  reset_closure_ = info->bus_reset_closure;
  if (info->bus_reset) {
    fw_cdev_event_bus_reset event{};
    event.closure = reset_closure_;
    event.type = FW_CDEV_EVENT_BUS_RESET;
    event.node_id = 0xFFC0u | static_cast<unsigned>(node_);
    event.local_node_id = event.root_node_id = event.irm_node_id = event.bm_node_id = 0xFFC0;
    event.generation = told_generation_;
    std::memcpy(pointer<void>(info->bus_reset), &event, sizeof event);
  }
  return 0;
}

// Reads or writes quadlets, which are in the order of the bus.
std::uint32_t DeviceFile::answer(std::uint32_t tcode, std::uint64_t offset,
                                 std::vector<std::uint32_t>& data) {
  CameraState* const state = camera();
  if (!state || offset < register_base) return RCODE_ADDRESS_ERROR;
  const BusLock lock(bus_);
  if (!state->is_on) power_on(*state);
  const bool reads = tcode == TCODE_READ_QUADLET_REQUEST || tcode == TCODE_READ_BLOCK_REQUEST;
  for (std::size_t i = 0; i < data.size(); ++i) {
    const std::uint64_t address = offset - register_base + 4 * i;
    if (reads) {
      const std::optional<std::uint32_t> value = read_register(*state, address);
      if (!value) return RCODE_ADDRESS_ERROR;
      data[i] = htonl(*value);
    } else if (!write_register(*state, address, ntohl(data[i]))) {
      return RCODE_ADDRESS_ERROR;
    }
  }
  return RCODE_COMPLETE;
}

int DeviceFile::send_request(const void* argument) {
  const auto& request = *static_cast<const fw_cdev_send_request*>(argument);
  if (request.length > longest_request || request.length % 4) return EINVAL;
  std::vector<std::uint32_t> data(request.length / 4);
  const bool writes =
      request.tcode == TCODE_WRITE_QUADLET_REQUEST || request.tcode == TCODE_WRITE_BLOCK_REQUEST;
  const bool reads =
      request.tcode == TCODE_READ_QUADLET_REQUEST || request.tcode == TCODE_READ_BLOCK_REQUEST;
  if (!reads && !writes) return EINVAL;
  if (writes && request.length)
    std::memcpy(data.data(), pointer<void>(request.data), request.length);
  const std::uint32_t generation = bus_.generation;
  if (told_generation_ != generation) tell_of_reset(generation);
  std::uint32_t code = RCODE_GENERATION;
  if (request.generation == generation) code = answer(request.tcode, request.offset, data);
  if (!reads || code != RCODE_COMPLETE) data.clear();
  std::vector<std::uint8_t> event(sizeof(fw_cdev_event_response) + data.size() * 4);
  fw_cdev_event_response head{};
  head.closure = request.closure;
  head.type = FW_CDEV_EVENT_RESPONSE;
  head.rcode = code;
  head.length = static_cast<std::uint32_t>(data.size() * 4);
  const std::size_t place = offsetof(fw_cdev_event_response, data);
  std::memcpy(event.data(), &head, place);
  if (!data.empty()) std::memcpy(event.data() + place, data.data(), data.size() * 4);
  events_->send(event.data(), event.size());
  return 0;
}

// The driver takes channels and bandwidth from the bus; what a process had that is no more, is
// free.
int DeviceFile::allocate(void* argument) {
  auto* request = static_cast<fw_cdev_allocate_iso_resource*>(argument);
  Resource resource{request->closure, -1};
  fw_cdev_event_iso_resource event{};
  event.closure = request->closure;
  event.type = FW_CDEV_EVENT_ISO_RESOURCE_ALLOCATED;
  event.channel = -EBUSY;  // as Linux says it, of missing bandwidth, too
  {
    const BusLock lock(bus_);
    std::uint64_t free = bus_.refuses_channels ? 0 : (1u << n_channels) - 1;
    int left = bus_.refuses_bandwidth ? 0 : bandwidth_units;
    Allocation* place = nullptr;
    for (Allocation& taken : bus_.allocations) {
      if (taken.owner && !is_running(taken.owner)) taken = {};
      if (!taken.owner) {
        place = &taken;
        continue;
      }
      if (taken.channel >= 0) free &= ~(std::uint64_t{1} << taken.channel);
      left -= taken.bandwidth;
    }
    free &= request->channels;
    const bool has_channel = !request->channels || free;
    const bool has_bandwidth = static_cast<int>(request->bandwidth) <= left;
    if (place && has_channel && has_bandwidth) {
      place->owner = static_cast<int>(getpid());
      place->file = number_;
      place->bandwidth = static_cast<int>(request->bandwidth);
      for (int c = 0; request->channels && place->channel < 0; ++c) {
        if (free >> c & 1) place->channel = c;
      }
      resource.index = static_cast<int>(place - bus_.allocations.data());
      event.channel = place->channel;
      event.bandwidth = place->bandwidth;
    }
  }
  event.handle = request->handle = next_handle_++;
  resources_.emplace(event.handle, resource);
  events_->send(&event, sizeof event);
  return 0;
}

void DeviceFile::release(int index) {
  if (index < 0) return;
  const BusLock lock(bus_);
  Allocation& taken = bus_.allocations[static_cast<std::size_t>(index)];
  if (taken.owner == getpid() && taken.file == number_) taken = {};
}

int DeviceFile::deallocate(const void* argument) {
  const auto handle = static_cast<const fw_cdev_deallocate*>(argument)->handle;
  const auto found = resources_.find(handle);
  if (found == resources_.end()) return EINVAL;
  fw_cdev_event_iso_resource event{};
  event.closure = found->second.closure;
  event.type = FW_CDEV_EVENT_ISO_RESOURCE_DEALLOCATED;
  event.handle = handle;
  release(found->second.index);
  resources_.erase(found);
  events_->send(&event, sizeof event);
  return 0;
}

}  // namespace robsim::virtual_bus
