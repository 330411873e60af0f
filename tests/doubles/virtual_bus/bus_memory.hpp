#pragma once

#include <errno.h>
#include <pthread.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

/// The virtual FireWire bus: cameras on a bus that is not there, for the unmodified libdc1394.
///
/// Its state lies in a file that several processes map: one makes it and writes pictures into it;
/// in others a preloaded library shows it as the device nodes of the kernel.
namespace robsim::virtual_bus {

constexpr std::uint64_t bus_magic = 0x3362'7573'3133'3934;  // of this layout
constexpr int most_cameras = 4;
constexpr int n_slots = 4;             // pictures of a camera that are kept
constexpr int bandwidth_units = 4915;  // of a bus, for isochronous packets: IEEE 1394, 8.4
constexpr int n_channels = 16;         // libdc1394 takes no others
constexpr const char* bus_variable = "ROBSIM_VIRTUAL_BUS";  // path of the file

/// How a camera codes pixels; the numbers are those of IIDC 1.31, 4.9.3.
enum class Coding : std::uint32_t {
  mono8 = 0,
  yuv411 = 1,
  yuv422 = 2,
  yuv444 = 3,
  rgb8 = 4,
  mono16 = 5,
  raw8 = 9
};

/// What somebody has taken of the bus.
struct Allocation {
  int owner = 0;  // number of the process; 0: nobody
  int file = 0;   // its open file
  int channel = -1;
  int bandwidth = 0;
};

/// A camera: what it can, its registers, its newest pictures.
struct CameraState {
  // Written by the maker before anybody looks:
  int width = 0, height = 0;       // px, of the sensor
  double fps = 0;                  // 1/s, of the sensor
  std::uint64_t guid = 0;          // number of this camera
  std::uint32_t codings = 0;       // bit n: that of number n
  std::uint32_t color_filter = 0;  // of raw8: 0 RGGB, 1 GBRG, 2 GRBG, 3 BGGR
  std::uint32_t speed = 2;         // 2: S400, 3: S800
  std::uint64_t pixels = 0;        // offset of the first picture in the file
  // Ordered by the maker at any time:
  std::atomic<bool> is_plugged_in{false};
  std::atomic<bool> is_denied{false};         // for lack of permission
  std::atomic<bool> is_short{false};          // says that a frame has half of its packets
  std::atomic<bool> is_plain{false};          // answers no question about its features
  std::atomic<std::int64_t> silent_until{0};  // ns, monotonic
  // Pictures: RGB, number n in slot n % n_slots.
  std::atomic<std::uint32_t> n_pictures{0};                  // how many there have been; a futex
  std::array<std::atomic<std::int64_t>, n_slots> exposed{};  // ns, monotonic
  std::atomic<std::uint32_t> n_lost{0};  // frames for which a reader had no buffer
  // Registers, under the lock of the bus:
  bool is_on = false;  // they have the values of the start
  std::array<std::uint32_t, 0x900 / 4> control{};
  std::array<std::uint32_t, 0x80 / 4> format7{};
};

struct BusMemory {
  std::uint64_t magic = 0;  // written last
  std::uint64_t size = 0;   // bytes of the file
  int n_cameras = 0;
  std::uint32_t card_speed = 3;  // as that of a camera
  pthread_mutex_t lock;          // of all processes
  std::atomic<std::uint32_t> generation{1};
  std::atomic<bool> refuses_channels{false};
  std::atomic<bool> refuses_bandwidth{false};
  std::array<Allocation, 16> allocations{};
  std::array<CameraState, most_cameras> cameras{};

  std::uint8_t* picture(const CameraState& camera, std::uint32_t number) {
    const std::size_t bytes = std::size_t{3} * static_cast<std::size_t>(camera.width) *
                              static_cast<std::size_t>(camera.height);
    return reinterpret_cast<std::uint8_t*>(this) + camera.pixels + number % n_slots * bytes;
  }
};

/// Holds the lock of a bus; whoever dies with it leaves it to the next.
class BusLock {
 public:
  explicit BusLock(BusMemory& bus) : lock_(bus.lock) {
    if (pthread_mutex_lock(&lock_) == EOWNERDEAD) pthread_mutex_consistent(&lock_);
  }
  ~BusLock() { pthread_mutex_unlock(&lock_); }
  BusLock(const BusLock&) = delete;
  BusLock& operator=(const BusLock&) = delete;

 private:
  pthread_mutex_t& lock_;
};

}  // namespace robsim::virtual_bus
