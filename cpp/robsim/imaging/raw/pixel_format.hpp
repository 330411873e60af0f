#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "robsim/imaging/image.hpp"

namespace robsim {

struct RawView;

/// How cameras send pixels, and what buses call it: a row of `pixel_formats`.
struct PixelFormat {
  struct Iidc {       // of FireWire; the numbers are those of IIDC 1.31, 4.9.3
    int coding = -1;  // -1: missing
    int worth = 0;    // of the coding, for finding colours
    int filter = 0;   // of raw8
  };
  struct GenICam {          // of GigE Vision
    const char* name = "";  // empty: missing
    std::int64_t code = -1;
  };

  const char* name;
  const char* coding;  // that a user asks of a camera
  int bits;            // of a pixel
  int unit;            // px; a row has whole units
  Iidc iidc;
  GenICam genicam;
  void (*convert)(const RawView& raw, const WritableView& rgb);  // of sizes that fit
  const char* filter = "";  // Bayer: colours of rows 0 and 1, as in "rggb"
};

/// All of them; those of GenICam in the order of their worth.
const std::vector<PixelFormat>& pixel_formats();

/// Throws std::invalid_argument that lists the names.
const PixelFormat& pixel_format_named(const std::string& name);

/// Throws std::invalid_argument unless width and height are above 0 and the format can have them:
/// rows of whole units, Bayer 2 x 2 px at least.
void check_size(const PixelFormat& format, int width, int height);

/// Of a row without a gap. Throws as `check_size`.
std::size_t bytes_of_row(const PixelFormat& format, int width);

/// Of all rows without gaps. Throws as `check_size`.
std::size_t bytes_of(const PixelFormat& format, int width, int height);

/// Pixels as a camera sent them, in the memory of somebody else. Nothing beyond the bytes of each
/// row is read.
struct RawView {
  const std::uint8_t* data = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;  // bytes from row to row
  const PixelFormat& format;
  int bits = 16;  // that a mono16 camera uses, 8 .. 16, the lowest ones: IIDC's "data depth"

  const std::uint8_t* row(int v) const { return data + v * stride; }
};

/// The view of rows without gaps. Throws std::invalid_argument for a size as `check_size`, and if
/// there are fewer than `bytes_of` them.
RawView raw_view(const std::uint8_t* data, std::size_t bytes, const PixelFormat& format, int width,
                 int height);

/// The pixels of a camera as RGB8. YUV is that of IIDC and JPEG (ITU-R BT.601, all of 0 .. 255), to
/// within a level of its real numbers; the chroma of two or four pixels is that of each. Of a
/// Bayer filter the missing colours are the means of the two or four neighbours that have them,
/// mirrored at the edges. Grey has three equal channels.
/// Throws std::invalid_argument as `check_size`, and if the sizes or the strides do not fit.
void to_rgb(const RawView& raw, const WritableView& rgb);

}  // namespace robsim
