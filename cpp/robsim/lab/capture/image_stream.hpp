#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "robsim/base/system.hpp"

namespace robsim {

/// Reads JPEG images from a connected socket as they come, in a thread of its own, and keeps the
/// newest: whoever takes it late, such as one who waits for an interpreter, gets no older one, and
/// the time when it really came.
class ImageStream {
 public:
  struct Taken {
    std::string jpeg;         // empty: nothing whole has come
    double arrived = 0;       // monotonic, s
    std::int64_t passed = 0;  // whole images before it that nobody took
    std::int64_t torn = 0;    // that were not whole
  };

  /// Takes a copy of the descriptor. `begun` has come already, with the header. `name` begins what
  /// errors say.
  ImageStream(int descriptor, std::string_view boundary, std::string_view begun, bool is_chunked,
              const std::string& name);
  ~ImageStream();

  /// What has come since the last one; none if nothing has within `timeout` s. Throws a
  /// CaptureError when the stream has ended and all is taken.
  std::optional<Taken> take(double timeout);

 private:
  struct State;
  OfProcess<State> state_;
};

}  // namespace robsim
