#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "robsim/imaging/image.hpp"

namespace robsim {

/// How cameras send pixels, by the orders of IIDC and GigE Vision. Bytes in memory:
///   yuv411  U Y Y V Y Y, of four pixels
///   yuv422  U Y V Y, of two pixels (not Y U Y V)
///   yuv444  U Y V
///   mono16  the high byte first, as IIDC sends it (not as GigE Vision does)
///   bayer   a byte per pixel; the name is the filter of rows 0 and 1: rggb = R G R G ..,
///           G B G B ..
enum class PixelFormat {
  mono8,
  mono16,
  yuv411,
  yuv422,
  yuv444,
  rgb8,
  bayer_rggb,
  bayer_grbg,
  bayer_gbrg,
  bayer_bggr
};

const char* name_of(PixelFormat format);

/// Throws std::invalid_argument that lists the names.
PixelFormat pixel_format_named(const std::string& name);

bool is_bayer(PixelFormat format);

/// Throws std::invalid_argument unless width and height are above 0 and the format can have them:
/// yuv411 multiples of 4 px a row, yuv422 of 2, Bayer 2 x 2 px at least.
void check_size(PixelFormat format, int width, int height);

/// Of a row without a gap. Throws as `check_size`.
std::size_t bytes_of_row(PixelFormat format, int width);

/// Of all rows without gaps. Throws as `check_size`.
std::size_t bytes_of(PixelFormat format, int width, int height);

/// Pixels as a camera sent them, in the memory of somebody else. Nothing beyond the bytes of each
/// row is read.
struct RawView {
  const std::uint8_t* data = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;  // bytes from row to row
  PixelFormat format = PixelFormat::mono8;
  int bits = 16;  // that a mono16 camera uses, 8 .. 16, the lowest ones: IIDC's "data depth"

  const std::uint8_t* row(int v) const { return data + v * stride; }
};

/// The view of rows without gaps. Throws std::invalid_argument for a size as `check_size`, and if
/// there are fewer than `bytes_of` them.
RawView raw_view(const std::uint8_t* data, std::size_t bytes, PixelFormat format, int width,
                 int height);

/// The pixels of a camera as RGB8. YUV is that of IIDC and JPEG (ITU-R BT.601, all of 0 .. 255), to
/// within a level of its real numbers; the chroma of two or four pixels is that of each. Of a
/// Bayer filter the missing colours are the means of the two or four neighbours that have them,
/// mirrored at the edges. Grey has three equal channels.
/// Throws std::invalid_argument as `check_size`, and if the sizes or the strides do not fit.
void to_rgb(const RawView& raw, const WritableView& rgb);

}  // namespace robsim
