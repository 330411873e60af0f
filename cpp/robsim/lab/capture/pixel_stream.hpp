#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "robsim/lab/capture/capture_device.hpp"

namespace robsim {

/// Reads frames that another process writes to a socket, for one thread.
class PixelStream {
 public:
  /// The head of a frame, as _devices/worker.py writes it.
  struct Head {
    std::uint32_t kind;  // of Kind
    std::uint32_t width, height;
    std::uint32_t length;        // of what follows, bytes
    std::uint32_t passed, torn;  // earlier images
    double arrived;              // monotonic, s
    double exposed;              // the same; NaN: unknown
  };
  enum Kind : std::uint32_t { opened, bgr, nothing, fault };

  /// Takes a copy of the descriptor. `name` begins what errors say. Throws CaptureError.
  PixelStream(int descriptor, std::string name);
  ~PixelStream();
  PixelStream(const PixelStream&) = delete;
  PixelStream& operator=(const PixelStream&) = delete;

  /// The next frame; nothing after 0.1 s or so without one. Throws the CaptureError that the other
  /// process tells, and `unplugged` when it has ended.
  std::optional<Captured> next(ImagePool& pool);

 private:
  bool fill(std::uint8_t* to, std::size_t size, double deadline);
  Captured captured(ImagePool& pool) const;
  [[noreturn]] void tell_fault() const;

  int descriptor_;
  std::string name_;
  Head head_{};
  std::vector<std::uint8_t> body_;
  bool has_head_ = false;
  std::size_t filled_ = 0;  // of the head, or of the body
};

}  // namespace robsim
