#include "robsim/vision/pixels/classify.hpp"

#include <algorithm>
#include <array>

#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/base/system.hpp"
#include "robsim/vision/pixels/bit_row.hpp"
#include "robsim/vision/pixels/yuv_avx.hpp"

namespace robsim::pixels {

namespace {

// With |R - G| <= d and |G - B| <= d:
//   U - 128 = floor((64 (B - G) + 22 (G - R))/128) lies within floor(-86 d/128)..floor(86 d/128)
//   V - 128 = floor((64 (R - G) + 10 (G - B))/128) lies within floor(-74 d/128)..floor(74 d/128)
bool excludes(const ColorClass& color, int d) {
  const int half_width[] = {86 * d, 74 * d};
  for (std::size_t i = 0; i < 2; ++i) {
    if (color.lower[i + 1] > 128 + (half_width[i] >> 7)) return true;
    if (color.upper[i + 1] < 128 + (-half_width[i] >> 7)) return true;
  }
  return false;
}

int safe_difference(const ColorClass& color) {
  int d = -1;
  while (d < 255 && excludes(color, d + 1)) ++d;
  return d;
}

// 255 for a byte whose successor is of the same pixel. The difference between the blue of a pixel
// and the red of the next one is masked out.
constexpr auto is_red_or_green = [] {
  std::array<std::uint8_t, 192> result{};
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = i % 3 == 2 ? 0 : 255;
  return result;
}();

// True if |R - G| or |G - B| of any of 64 pixels exceeds the limit. Reads one byte beyond them. The
// loop runs over all neighbours in memory, so that the compiler can vectorise it.
ROBSIM_INLINE bool is_colorful(const std::uint8_t* bytes, int limit) {
  std::uint8_t maximum = 0;
  for (int i = 0; i < 192; ++i) {
    const std::uint8_t a = bytes[i];
    const std::uint8_t b = bytes[i + 1];
    const std::uint8_t difference = static_cast<std::uint8_t>((a > b ? a : b) - (a > b ? b : a));
    const std::uint8_t counted = difference & is_red_or_green[i];
    maximum = maximum > counted ? maximum : counted;
  }
  return maximum > limit;
}

ROBSIM_INLINE void screen_row(PaddedRow& row, int limit, BitRow& may_contain) {
  for (std::size_t block = 0; block < row.blocks(); ++block) {
    const std::uint8_t* pixels = row.block(block);
    prefetch(pixels);
    may_contain[block / 64] |= std::uint64_t{is_colorful(pixels, limit)} << (block % 64);
  }
}

#if ROBSIM_HAS_AVX512_CODE

// 1, 2, ... 64: where the successors of 64 bytes lie in their register and the next one
constexpr auto successors = [] {
  std::array<std::uint8_t, 64> result{};
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = static_cast<std::uint8_t>(i + 1);
  return result;
}();

// |byte i - byte i+1|, 64 times. Shifting in registers costs less than loads of any alignment.
ROBSIM_AVX512_INLINE __m512i differences(__m512i bytes, __m512i next) {
  const __m512i b = _mm512_permutex2var_epi8(bytes, simd::load_wide(successors.data()), next);
  return _mm512_or_si512(_mm512_subs_epu8(bytes, b), _mm512_subs_epu8(b, bytes));
}

ROBSIM_AVX512_INLINE void screen_avx512(PaddedRow& row, int limit, BitRow& may_contain) {
  const __m512i limits = _mm512_set1_epi8(static_cast<char>(limit));
  for (std::size_t block = 0; block < row.blocks(); ++block) {
    const std::uint8_t* pixels = row.block(block);
    prefetch(pixels);
    __m512i maximum = _mm512_setzero_si512();
    __m512i bytes = simd::load_wide(pixels);
    for (int i = 0; i < 3; ++i) {
      // The last byte of all is a blue one, whose successor does not count.
      const __m512i next = i < 2 ? simd::load_wide(pixels + 64 * (i + 1)) : bytes;
      maximum = _mm512_max_epu8(
          maximum,
          _mm512_and_si512(differences(bytes, next), simd::load_wide(&is_red_or_green[64 * i])));
      bytes = next;
    }
    const bool is_colorful = _mm512_cmpgt_epu8_mask(maximum, limits) != 0;
    may_contain[block / 64] |= std::uint64_t{is_colorful} << (block % 64);
  }
}

#endif

}  // namespace

ChromaScreen::ChromaScreen(const std::vector<ColorClass>& classes) : safe_difference_(255) {
  for (const ColorClass& color : classes) {
    safe_difference_ = std::min(safe_difference_, safe_difference(color));
  }
}

void ChromaScreen::screen(const std::uint8_t* rgb, int width, BitRow& may_contain) const {
  PaddedRow row(rgb, width);
  const auto blocks = static_cast<int>(row.blocks());
  if (safe_difference_ < 0) {
    set_all(may_contain, blocks);
    return;
  }
  may_contain.assign(words_of(blocks), 0);
  ROBSIM_PICK(screen_row, screen_row, screen_avx512)(row, safe_difference_, may_contain);
}

namespace {

std::vector<ChannelLimits> limits_of(const ColorClass& color) {
  std::vector<ChannelLimits> limits;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const int lower = color.lower[channel];
    const int upper = color.upper[channel];
    if (lower == 0 && upper == 255) continue;
    limits.push_back({channel, static_cast<std::uint8_t>(lower), static_cast<std::uint8_t>(upper)});
  }
  return limits;
}

// The members of a class among 64 pixels, in loops that the compiler can vectorise.
ROBSIM_INLINE std::uint64_t members(Planes& planes, const std::vector<ChannelLimits>& limits) {
  std::uint8_t is_member[64];
  std::fill_n(is_member, 64, std::uint8_t{1});
  for (const ChannelLimits& limit : limits) {
    const std::uint8_t* values = planes[limit.channel];
    const std::uint8_t lower = limit.lower;
    const std::uint8_t upper = limit.upper;
    for (int i = 0; i < 64; ++i) is_member[i] &= (values[i] >= lower) & (values[i] <= upper);
  }
  return pack_bits(is_member);
}

template <auto convert>
ROBSIM_INLINE void classify_row(const std::uint8_t* rgb, int width,
                                const std::vector<std::vector<ChannelLimits>>& limits,
                                const BitRow& may_contain, std::vector<BitRow>& bits) {
  PaddedRow row(rgb, width);
  std::uint8_t yuv[3][64];
  std::uint8_t* const planes[3] = {yuv[0], yuv[1], yuv[2]};
  for (std::size_t word = 0; word < row.blocks(); ++word) {
    if (!is_set(may_contain, static_cast<int>(word))) continue;
    convert(row.block(word), planes);
    for (std::size_t i = 0; i < limits.size(); ++i) bits[i][word] = members(planes, limits[i]);
  }
}

}  // namespace

Classifier::Classifier(const std::vector<ColorClass>& classes) : screen_(classes) {
  checked(classes.size(), classes.size() <= maximum_classes, "colors must be at most 32 classes");
  for (const ColorClass& color : classes) limits_.push_back(limits_of(color));
}

void Classifier::classify(const std::uint8_t* rgb, int width, std::vector<BitRow>& bits) {
  for (BitRow& row : bits) row.assign(words_of(width), 0);
  screen_.screen(rgb, width, may_contain_);
  if (is_empty(may_contain_)) return;
  ROBSIM_PICK(classify_row<convert_64>, classify_row<convert_64_avx2>,
              classify_row<convert_64_avx512>)(rgb, width, limits_, may_contain_, bits);
  clear_beyond(bits, width);
}

}  // namespace robsim::pixels
