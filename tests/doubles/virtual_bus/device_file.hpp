#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "virtual_bus/bus_memory.hpp"

namespace robsim::virtual_bus {

class IsoReceiver;

/// The other end of a descriptor, to which events are sent that whoever opened the file reads.
class EventQueue {
 public:
  explicit EventQueue(int descriptor) : descriptor_(descriptor) {}
  ~EventQueue();
  EventQueue(const EventQueue&) = delete;
  EventQueue& operator=(const EventQueue&) = delete;

  void send(const void* event, std::size_t size);

  /// Waits until nobody is sending.
  void wait();

  /// Whoever waits for events is woken, and finds none.
  void hang_up();

 private:
  std::mutex mutex_;
  int descriptor_;
};

/// An open device node: what the kernel's driver does for it (linux/firewire-cdev.h).
class DeviceFile {
 public:
  /// `queue` is the other end of its descriptor.
  DeviceFile(BusMemory& bus, int node, int queue);
  ~DeviceFile();
  DeviceFile(const DeviceFile&) = delete;
  DeviceFile& operator=(const DeviceFile&) = delete;

  /// What the kernel returns: 0 or more, or the number of an error less than 0.
  int control(unsigned long request, void* argument);

  /// An event has been read. A frame was written before its event was sent: by the rules of C++ it
  /// may be read after a lock that both took, of which a descriptor knows nothing.
  void has_been_read() { events_->wait(); }

  /// Whether its node is there still, and is the one that was opened.
  bool is_alive() const;

 private:
  CameraState* camera() const;
  int speed() const;
  int perform(unsigned long request, void* argument);
  int get_info(void* argument);
  int send_request(const void* argument);
  std::uint32_t answer(std::uint32_t tcode, std::uint64_t offset, std::vector<std::uint32_t>& data);
  int allocate(void* argument);
  int deallocate(const void* argument);
  void release(int index);
  void tell_of_reset(std::uint32_t generation);

  BusMemory& bus_;
  const int node_;
  const int number_;  // of this file in this process
  std::mutex mutex_;
  std::shared_ptr<EventQueue> events_;
  std::uint32_t told_generation_;
  std::uint64_t reset_closure_ = 0;
  struct Resource {
    std::uint64_t closure;
    int index;  // among the allocations of the bus; -1: none was to be had
  };
  std::map<std::uint32_t, Resource> resources_;
  std::uint32_t next_handle_ = 0;
  std::unique_ptr<IsoReceiver> receiver_;
};

/// Time of the bus: 7 bits of seconds, 13 of cycles of 125 us, 12 of 1/3072 cycles.
std::uint32_t cycle_timer_at(std::int64_t ns);
std::int64_t now_ns();

}  // namespace robsim::virtual_bus
