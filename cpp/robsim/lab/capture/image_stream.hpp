#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "robsim/base/system.hpp"

namespace robsim {

/// Cuts a multipart stream, in any pieces, into the bodies of its parts.
///
/// A part ends at its Content-Length, or where the next boundary begins if that comes before: then
/// it was cut short. Without a length it ends with the end marker of JPEG, so that an image is
/// there as soon as its last byte, and not only when the next one begins.
class Multipart {
 public:
  /// `boundary` as the header of the stream names it, with or without the two dashes before it.
  explicit Multipart(std::string_view boundary);

  /// Takes what has come.
  void feed(std::string_view bytes) { data_ += bytes; }

  /// The next part; none if there is no whole one yet.
  std::optional<std::string> next();

 private:
  bool skip_head();
  std::size_t find_marker(std::size_t from) const;
  std::optional<std::size_t> end_of_body();

  std::string marker_, data_;
  bool is_in_body_ = false;
  std::optional<std::size_t> length_;
  std::size_t searched_ = 0;  // bytes that hold no marker
};

/// Takes the chunks off a body of HTTP: RFC 9112, 7.1.
class Chunks {
 public:
  /// The content of what has come; nothing after the last chunk. Throws std::invalid_argument if
  /// these are no chunks.
  std::string decoded(std::string_view bytes);

 private:
  void begin_chunk();

  std::string line_;      // the size of the next chunk, as far as it has come
  std::size_t left_ = 0;  // bytes of this chunk
  bool is_over_ = false;
};

/// True if a JPEG image has all of its blocks, and nothing else, between its header and its end
/// marker: ITU-T T.81. Decoders fill up what is missing, and do not say so. Of progressive and
/// arithmetic coding the end marker alone is looked at.
bool is_whole_jpeg(const std::uint8_t* data, std::size_t size);

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
