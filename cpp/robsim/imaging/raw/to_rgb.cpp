#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/base/system.hpp"
#include "robsim/imaging/raw/blocks.hpp"
#include "robsim/imaging/raw/pixel_format.hpp"

namespace robsim::raw {

namespace {

ROBSIM_INLINE void mono8_row(const std::uint8_t* raw, int width, std::uint8_t* rgb) {
  for (int u = 0; u < width; ++u) rgb[3 * u] = rgb[3 * u + 1] = rgb[3 * u + 2] = raw[u];
}

ROBSIM_INLINE void mono16_row(const std::uint8_t* raw, int width, int bits, std::uint8_t* rgb) {
  for (int u = 0; u < width; ++u) {
    const int grey = ((raw[2 * u] << 8) | raw[2 * u + 1]) >> (bits - 8);
    rgb[3 * u] = rgb[3 * u + 1] = rgb[3 * u + 2] = static_cast<std::uint8_t>(std::min(grey, 255));
  }
}

// Where a unit of pixels has their Y, and the U and V that they share: of the order of its bytes.
struct Unit {
  constexpr explicit Unit(const char* order) {
    for (; order[bytes]; ++bytes) {
      (order[bytes] == 'Y' ? y[pixels++] : order[bytes] == 'U' ? u : v) = bytes;
    }
  }
  int pixels = 0, bytes = 0, y[4] = {}, u = 0, v = 0;
};

constexpr Unit uyyvyy("UYYVYY"), uyvy("UYVY"), yuyv("YUYV"), uyv("UYV");

// R = Y + 1.402 (V - 128)
// G = Y - 0.344136 (U - 128) - 0.714136 (V - 128)
// B = Y + 1.772 (U - 128)
// Source: ITU-R BT.601; JFIF 1.02. Here in units of 1/64, factors in units of 1/16384: the
// products have room in 16 bits of a vector once they are rounded to 1/64.
constexpr int red_of_v = 22970;
constexpr int green_of_u = 5638;
constexpr int green_of_v = 11700;
constexpr int blue_of_u = 29032;

// All values fit in 16 bits, so that twice as many fit in a vector.
std::int16_t chroma_term(int factor, int chroma) {
  return static_cast<std::int16_t>((factor * chroma + 128) >> 8);
}

std::uint8_t level(int sixty_fourths) {
  const auto rounded =
      static_cast<std::int16_t>(static_cast<std::int16_t>(sixty_fourths + 32) >> 6);
  const std::int16_t not_negative = rounded < 0 ? std::int16_t{0} : rounded;
  return static_cast<std::uint8_t>(not_negative > 255 ? std::int16_t{255} : not_negative);
}

// The channels of 32 pixels, each for itself, so that the compiler can vectorise the loop over
// them.
void convert_planes(const std::int16_t* y, const std::int16_t* u, const std::int16_t* v,
                    std::uint8_t (&channels)[3][pixels_of_block]) {
  for (int i = 0; i < pixels_of_block; ++i) {
    const int green = chroma_term(green_of_u, u[i]) + chroma_term(green_of_v, v[i]);
    channels[0][i] = level(64 * y[i] + chroma_term(red_of_v, v[i]));
    channels[1][i] = level(64 * y[i] - green);
    channels[2][i] = level(64 * y[i] + chroma_term(blue_of_u, u[i]));
  }
}

template <const Unit& unit>
void yuv_row_baseline(const std::uint8_t* raw, int width, std::uint8_t* rgb) {
  std::int16_t planes[3][pixels_of_block] = {};
  std::uint8_t channels[3][pixels_of_block];
  for (int first = 0; first < width; first += pixels_of_block) {
    const int count = std::min(width - first, pixels_of_block);
    for (int i = 0; i < count; i += unit.pixels, raw += unit.bytes) {
      for (int k = 0; k < unit.pixels; ++k) {
        planes[0][i + k] = raw[unit.y[k]];
        planes[1][i + k] = static_cast<std::int16_t>(raw[unit.u] - 128);
        planes[2][i + k] = static_cast<std::int16_t>(raw[unit.v] - 128);
      }
    }
    convert_planes(planes[0], planes[1], planes[2], channels);
    for (int i = 0; i < count; ++i, rgb += 3) {
      for (int channel = 0; channel < 3; ++channel) rgb[channel] = channels[channel][i];
    }
  }
}

#if ROBSIM_HAS_AVX2_CODE

enum class Plane { y, u, v };

// Takes the values of a plane of 8 pixels to the high bytes of 8 lanes of 16 bits. They are in the
// 16 bytes from `offset` on; bytes that are not there become 0.
template <const Unit& unit>
constexpr Indices high_bytes_of(Plane plane, int offset) {
  Indices from{};
  for (int i = 0; i < 8; ++i) {
    const int in_unit = plane == Plane::y   ? unit.y[i % unit.pixels]
                        : plane == Plane::u ? unit.u
                                            : unit.v;
    const int at = i / unit.pixels * unit.bytes + in_unit;
    const bool is_there = at >= offset && at < offset + 16 && (offset == 0 || at >= 16);
    from[static_cast<std::size_t>(2 * i)] = -1;
    from[static_cast<std::size_t>(2 * i + 1)] =
        static_cast<std::int8_t>(is_there ? at - offset : -1);
  }
  return from;
}

template <const Unit& unit, Plane plane>
ROBSIM_AVX2_INLINE __m256i lanes_of(const std::uint8_t* low, const std::uint8_t* high) {
  static constexpr Indices of_first = high_bytes_of<unit>(plane, 0);
  const __m256i first = _mm256_shuffle_epi8(simd::load_halves(low, high), in_both_halves(of_first));
  if constexpr (8 / unit.pixels * unit.bytes <= 16) {
    return first;
  } else {
    static constexpr Indices of_second = high_bytes_of<unit>(plane, 8);
    const __m256i second =
        _mm256_shuffle_epi8(simd::load_halves(low + 8, high + 8), in_both_halves(of_second));
    return _mm256_or_si256(first, second);
  }
}

// Red, green and blue of 16 pixels in lanes of 16 bits, not yet within 0 .. 255.
struct RgbLanes {
  __m256i channel[3];
};

// Of chroma in units of 1/256: (256 c factor/2 + 2^14) >> 15, which is `chroma_term`.
ROBSIM_AVX2_INLINE __m256i chroma_terms(int factor, __m256i chroma) {
  return _mm256_mulhrs_epi16(chroma, _mm256_set1_epi16(static_cast<short>(factor / 2)));
}

ROBSIM_AVX2_INLINE __m256i levels(__m256i sixty_fourths) {
  return _mm256_srai_epi16(sixty_fourths, 6);
}

// Of 8 pixels each at two places.
template <const Unit& unit>
ROBSIM_AVX2_INLINE RgbLanes rgb_lanes(const std::uint8_t* low, const std::uint8_t* high) {
  const __m256i minus_128 = _mm256_set1_epi16(static_cast<short>(0x8000));
  const __m256i u = _mm256_xor_si256(lanes_of<unit, Plane::u>(low, high), minus_128);
  const __m256i v = _mm256_xor_si256(lanes_of<unit, Plane::v>(low, high), minus_128);
  const __m256i y = _mm256_add_epi16(_mm256_srli_epi16(lanes_of<unit, Plane::y>(low, high), 2),
                                     _mm256_set1_epi16(32));
  const __m256i green = _mm256_add_epi16(chroma_terms(green_of_u, u), chroma_terms(green_of_v, v));
  return {{levels(_mm256_add_epi16(y, chroma_terms(red_of_v, v))),
           levels(_mm256_sub_epi16(y, green)),
           levels(_mm256_add_epi16(y, chroma_terms(blue_of_u, u)))}};
}

template <const Unit& unit>
ROBSIM_AVX2 inline void yuv_row_avx2(const std::uint8_t* raw, int width, std::uint8_t* rgb) {
  constexpr int bits = 8 * unit.bytes / unit.pixels;
  // Packing works within halves: pixels 0..7 and 16..23 are joined with 8..15 and 24..31.
  for_each_block<bits>(raw, width, rgb, [](const std::uint8_t* from, std::uint8_t* to) ROBSIM_AVX2 {
    const RgbLanes even = rgb_lanes<unit>(from, from + 2 * bits);
    const RgbLanes odd = rgb_lanes<unit>(from + bits, from + 3 * bits);
    store_rgb(_mm256_packus_epi16(even.channel[0], odd.channel[0]),
              _mm256_packus_epi16(even.channel[1], odd.channel[1]),
              _mm256_packus_epi16(even.channel[2], odd.channel[2]), to);
  });
}

#endif

template <typename Convert>
void convert_rows(const RawView& raw, const WritableView& rgb, Convert&& convert) {
  for (int v = 0; v < raw.height; ++v) convert(raw.row(v), raw.width, rgb.row(v));
}

void convert_mono8(const RawView& raw, const WritableView& rgb) {
  convert_rows(raw, rgb, ROBSIM_PICK(mono8_row));
}

void convert_mono16(const RawView& raw, const WritableView& rgb) {
  convert_rows(raw, rgb, [&](const std::uint8_t* from, int width, std::uint8_t* to) {
    ROBSIM_PICK(mono16_row)(from, width, raw.bits, to);
  });
}

template <const Unit& unit>
void convert_yuv(const RawView& raw, const WritableView& rgb) {
  convert_rows(raw, rgb, ROBSIM_PICK(yuv_row_baseline<unit>, yuv_row_avx2<unit>));
}

template <void (*copied)(const ImageView&, const WritableView&)>
void convert_rgb(const RawView& raw, const WritableView& rgb) {
  copied({raw.data, raw.width, raw.height, raw.stride}, rgb);
}

}  // namespace

}  // namespace robsim::raw

namespace robsim {

const std::vector<PixelFormat>& pixel_formats() {
  using namespace raw;
  static const std::vector<PixelFormat> formats{
      {"rgb8", "rgb8", 24, 1, {4, 6}, {"RGB8", 0x02180014}, convert_rgb<copy>},
      {"bgr8", "rgb8", 24, 1, {}, {"BGR8", 0x02180015}, convert_rgb<copy_bgr>},
      {"yuv444", "yuv444", 24, 1, {3, 5}, {}, convert_yuv<uyv>},
      {"bayer_rggb", "raw8", 8, 1, {9, 4, 0}, {"BayerRG8", 0x01080009}, convert_bayer, "rggb"},
      {"bayer_grbg", "raw8", 8, 1, {9, 4, 2}, {"BayerGR8", 0x01080008}, convert_bayer, "grbg"},
      {"bayer_gbrg", "raw8", 8, 1, {9, 4, 1}, {"BayerGB8", 0x0108000A}, convert_bayer, "gbrg"},
      {"bayer_bggr", "raw8", 8, 1, {9, 4, 3}, {"BayerBG8", 0x0108000B}, convert_bayer, "bggr"},
      {"yuv422", "yuv422", 16, 2, {2, 7}, {"YUV422_8_UYVY", 0x0210001F}, convert_yuv<uyvy>},
      {"yuyv", "yuv422", 16, 2, {}, {"YUV422_8", 0x02100032}, convert_yuv<yuyv>},
      {"yuv411", "yuv411", 12, 4, {1, 3}, {}, convert_yuv<uyyvyy>},
      {"mono8", "mono8", 8, 1, {0, 2}, {"Mono8", 0x01080001}, convert_mono8},
      // IIDC sends the high byte first. Mono16 of GenICam has the low byte first.
      {"mono16", "mono16", 16, 1, {5, 1}, {}, convert_mono16},
  };
  return formats;
}

namespace {

void check_views(const RawView& raw, const WritableView& rgb) {
  check_size(raw.format, raw.width, raw.height);
  if (rgb.width != raw.width || rgb.height != raw.height) {
    throw std::invalid_argument("rgb must have the size of the raw frame, " +
                                size_text(raw.width, raw.height) + ", got " +
                                size_text(rgb.width, rgb.height));
  }
  const auto row = static_cast<std::ptrdiff_t>(bytes_of_row(raw.format, raw.width));
  if (raw.stride < row || rgb.stride < std::ptrdiff_t{3} * rgb.width) {
    throw std::invalid_argument("stride must be at least the bytes of a row");
  }
  checked(raw.bits, raw.bits >= 8 && raw.bits <= 16, "bits must be 8 .. 16");
}

}  // namespace

void to_rgb(const RawView& raw, const WritableView& rgb) {
  check_views(raw, rgb);
  raw.format.convert(raw, rgb);
}

}  // namespace robsim
