#pragma once

#include <linux/firewire-cdev.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "virtual_bus/device_file.hpp"
#include "virtual_bus/iidc_features.hpp"
#include "virtual_bus/iidc_registers.hpp"

namespace robsim::virtual_bus {

/// A context that receives isochronous packets, as the kernel's driver has it: the packets of the
/// cameras that send on its channel go into the buffers that are queued. Where there is no buffer
/// they are lost.
class IsoReceiver {
 public:
  IsoReceiver(BusMemory& bus, std::shared_ptr<EventQueue> events, std::uint32_t channel,
              std::uint32_t header_bytes, std::uint64_t closure);
  ~IsoReceiver() { stop(); }

  /// 0, or the number of an error.
  int queue(const fw_cdev_queue_iso& request);
  void start();
  void stop();

 private:
  struct Buffer {
    std::uint8_t* data;
    std::size_t size;
  };

  void run();
  CameraState* wait_for_picture(std::uint32_t& number);
  bool receive(CameraState& camera, std::uint32_t number);
  bool fill(CameraState& camera, std::uint32_t number, const Transmission& sent,
            const Brightness& light, const Buffer& buffer);
  void report(const Transmission& sent, std::int64_t start) const;
  void tell_of_reset() const;

  BusMemory& bus_;
  const std::shared_ptr<EventQueue> events_;
  const int channel_;
  const std::size_t header_bytes_;  // of a packet
  const std::uint64_t closure_;
  std::mutex mutex_;
  std::deque<Buffer> buffers_;
  std::atomic<bool> stops_{false};
  std::thread thread_;
  std::vector<std::uint8_t> seen_;   // a picture as its settings make it
  std::vector<std::uint8_t> coded_;  // a frame for which the buffer is too small
};

}  // namespace robsim::virtual_bus
