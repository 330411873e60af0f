#include "virtual_bus/iso_receiver.hpp"

#include <arpa/inet.h>
#include <linux/futex.h>
#include <pthread.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <string>

#include "raw/from_rgb.hpp"
#include "robsim/base/system.hpp"
#include "robsim/imaging/image.hpp"

namespace robsim::virtual_bus {

namespace {

constexpr std::int64_t cycle = 125'000;            // ns
constexpr std::int64_t longest_wait = 20'000'000;  // ns

void sleep_ns(std::int64_t ns) {
  const timespec time{ns / 1'000'000'000, ns % 1'000'000'000};
  nanosleep(&time, nullptr);
}

// Until the word is no longer `seen`, or for the longest wait.
void wait_while(std::atomic<std::uint32_t>& word, std::uint32_t seen) {
  const timespec time{0, longest_wait};
  syscall(SYS_futex, &word, FUTEX_WAIT, seen, &time, nullptr, 0);
}

const PixelFormat& format_of(const CameraState& camera, Coding coding) {
  constexpr std::array filters{"rggb", "gbrg", "grbg", "bggr"};  // in IIDC's order
  constexpr std::array names{"mono8", "yuv411", "yuv422", "yuv444", "rgb8", "mono16"};
  return pixel_format_named(coding == Coding::raw8
                                ? std::string("bayer_") + filters[camera.color_filter & 3]
                                : names[static_cast<std::size_t>(coding)]);
}

using Table = std::array<std::uint8_t, 256>;

Table brighter(double factor) {
  Table table;
  for (std::size_t value = 0; value < table.size(); ++value) {
    table[value] =
        static_cast<std::uint8_t>(std::min(255.0, std::round(factor * static_cast<double>(value))));
  }
  return table;
}

}  // namespace

IsoReceiver::IsoReceiver(BusMemory& bus, std::shared_ptr<EventQueue> events, std::uint32_t channel,
                         std::uint32_t header_bytes, std::uint64_t closure)
    : bus_(bus),
      events_(std::move(events)),
      channel_(static_cast<int>(channel)),
      header_bytes_(header_bytes),
      closure_(closure) {}

// One request holds the packets of one frame, as libdc1394 has it.
int IsoReceiver::queue(const fw_cdev_queue_iso& request) {
  const auto* const words =
      reinterpret_cast<const std::uint32_t*>(static_cast<std::uintptr_t>(request.packets));
  std::size_t size = 0;
  for (std::size_t i = 0; i < request.size / sizeof(fw_cdev_iso_packet); ++i) {
    size += words[i] & 0xFFFF;
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  buffers_.push_back(
      {reinterpret_cast<std::uint8_t*>(static_cast<std::uintptr_t>(request.data)), size});
  return 0;
}

void IsoReceiver::start() {
  if (thread_.joinable()) return;
  stops_ = false;
  thread_ = start_thread([this] { run(); });
}

void IsoReceiver::stop() {
  stops_ = true;
  if (thread_.joinable()) thread_.join();
  const std::lock_guard<std::mutex> lock(mutex_);
  buffers_.clear();
}

void IsoReceiver::run() {
  pthread_setname_np(pthread_self(), "virtual bus");  // so that its share can be told apart
  const auto n_cameras = static_cast<std::size_t>(bus_.n_cameras);
  std::array<std::uint32_t, most_cameras> seen{};
  for (std::size_t i = 0; i < n_cameras; ++i) seen[i] = bus_.cameras[i].n_pictures;
  std::uint32_t generation = bus_.generation;
  while (!stops_) {
    if (generation != bus_.generation) {
      generation = bus_.generation;
      tell_of_reset();
    }
    CameraState* source = nullptr;
    std::size_t index = 0;
    for (std::size_t i = 0; i < n_cameras; ++i) {
      CameraState& camera = bus_.cameras[i];
      const BusLock lock(bus_);
      const bool sends = camera.is_plugged_in && camera.is_on;
      const Transmission sent = sends ? transmission_of(camera) : Transmission{};
      if (sent.is_on && sent.channel == channel_ && sent.speed <= bus_.card_speed) {
        source = &camera;
        index = i;
      } else {
        seen[i] = camera.n_pictures;
      }
    }
    if (!source) {
      sleep_ns(longest_wait / 10);
      continue;
    }
    const std::uint32_t newest = source->n_pictures;
    if (newest == seen[index]) {
      wait_while(source->n_pictures, newest);
      continue;
    }
    // Older ones are overwritten meanwhile: a late receiver continues with the newest.
    if (newest - seen[index] >= n_slots) seen[index] = newest - 1;
    receive(*source, seen[index]++);
  }
}

bool IsoReceiver::receive(CameraState& camera, std::uint32_t number) {
  Transmission sent;
  Brightness light;
  {
    const BusLock lock(bus_);
    sent = transmission_of(camera);
    light = brightness_of(camera);
  }
  const std::int64_t start = camera.exposed[number % n_slots];
  if (!sent.is_on || number % static_cast<std::uint32_t>(sent.every) ||
      start < camera.silent_until) {
    return false;
  }
  Buffer buffer{};
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (buffers_.empty()) {  // overrun
      ++camera.n_lost;
      return false;
    }
    buffer = buffers_.front();
    buffers_.pop_front();
  }
  if (!fill(camera, number, sent, light, buffer)) {
    const std::lock_guard<std::mutex> lock(mutex_);
    buffers_.push_front(buffer);
    return false;
  }
  // The last packet comes when all the others have had their cycles.
  const std::int64_t end = start + sent.n_packets * cycle;
  while (!stops_ && now_ns() < end) sleep_ns(std::min(end - now_ns() + 1000, longest_wait));
  if (stops_ || !camera.is_plugged_in) return false;
  report(sent, start);
  return true;
}

// False if the picture has been overwritten meanwhile.
bool IsoReceiver::fill(CameraState& camera, std::uint32_t number, const Transmission& sent,
                       const Brightness& light, const Buffer& buffer) {
  const PixelFormat& format = format_of(camera, sent.coding);
  const std::ptrdiff_t stride = 3 * std::ptrdiff_t{camera.width};
  const std::ptrdiff_t row_bytes = 3 * std::ptrdiff_t{sent.width};
  seen_.resize(static_cast<std::size_t>(row_bytes * sent.height));
  const ImageView seen{seen_.data(), sent.width, sent.height, row_bytes};
  // On a busy machine the coding takes longer than a picture lasts.
  copy({bus_.picture(camera, number) + sent.top * stride + 3 * sent.left, sent.width, sent.height,
        stride},
       {seen_.data(), sent.width, sent.height, row_bytes});
  if (camera.n_pictures - number >= n_slots) return false;
  if (light.red != 1 || light.green != 1 || light.blue != 1) {
    const std::array<Table, 3> tables{brighter(light.red), brighter(light.green),
                                      brighter(light.blue)};
    for (std::size_t i = 0; i < seen_.size(); ++i) seen_[i] = tables[i % 3][seen_[i]];
  }
  const std::size_t bytes = bytes_of(format, sent.width, sent.height);
  if (buffer.size < bytes) {  // the packets that there is room for
    coded_.resize(bytes);
    from_rgb(seen, format, coded_.data());
    std::memcpy(buffer.data, coded_.data(), buffer.size);
  } else {
    from_rgb(seen, format, buffer.data);
  }
  return true;
}

void IsoReceiver::report(const Transmission& sent, std::int64_t start) const {
  const auto n_packets = static_cast<std::size_t>(sent.n_packets);
  const std::size_t place = offsetof(fw_cdev_event_iso_interrupt, header);
  std::vector<std::uint8_t> event(place + n_packets * header_bytes_);
  fw_cdev_event_iso_interrupt head{};
  head.closure = closure_;
  head.type = FW_CDEV_EVENT_ISO_INTERRUPT;
  head.cycle = cycle_timer_at(start + (sent.n_packets - 1) * cycle) >> 12 & 0xFFFF;
  head.header_length = static_cast<std::uint32_t>(n_packets * header_bytes_);
  std::memcpy(event.data(), &head, place);
  for (std::size_t i = 0; i < n_packets; ++i) {
    // Length, channel and tcode, sy; then the cycle in which it came.
    const std::uint32_t words[2] = {
        htonl(static_cast<std::uint32_t>(sent.packet_bytes) << 16 |
              static_cast<std::uint32_t>(channel_) << 8 | 0xA0 | (i == 0)),
        htonl(cycle_timer_at(start + static_cast<std::int64_t>(i) * cycle) >> 12 & 0xFFFF)};
    std::memcpy(event.data() + place + i * header_bytes_, words,
                std::min(header_bytes_, sizeof words));
  }
  events_->send(event.data(), event.size());
}

void IsoReceiver::tell_of_reset() const {
  fw_cdev_event_bus_reset event{};
  event.type = FW_CDEV_EVENT_BUS_RESET;
  event.generation = bus_.generation;
  events_->send(&event, sizeof event);
}

}  // namespace robsim::virtual_bus
