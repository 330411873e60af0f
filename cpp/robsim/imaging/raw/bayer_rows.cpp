#include <algorithm>
#include <cstddef>
#include <cstring>
#include <vector>

#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/imaging/raw/blocks.hpp"
#include "robsim/imaging/raw/pixel_format.hpp"

namespace robsim::raw {

namespace {

int mean_of_2(int a, int b) { return (a + b + 1) >> 1; }
int mean_of_4(int a, int b, int c, int d) { return (a + b + c + d + 2) >> 2; }

// A row with its neighbours, each with its mirrored pixels at both ends.
struct ThreeRows {
  const std::uint8_t* above;
  const std::uint8_t* row;
  const std::uint8_t* below;
};

// Channel `own`, 0 or 2, is that of the row's pixels that are not green, `other` that of the rows
// above and below.
template <bool is_green_first>
void bayer_row_baseline(const ThreeRows& rows, int width, int own, std::uint8_t* rgb) {
  const auto& [above, row, below] = rows;
  const int other = 2 - own;
  for (int u = 0; u < width; ++u, rgb += 3) {
    const auto set = [&](int channel, int value) {
      rgb[channel] = static_cast<std::uint8_t>(value);
    };
    if ((u % 2 == 0) == is_green_first) {
      set(own, mean_of_2(row[u - 1], row[u + 1]));
      set(1, row[u]);
      set(other, mean_of_2(above[u], below[u]));
    } else {
      set(own, row[u]);
      set(1, mean_of_4(row[u - 1], row[u + 1], above[u], below[u]));
      set(other, mean_of_4(above[u - 1], above[u + 1], below[u - 1], below[u + 1]));
    }
  }
}

#if ROBSIM_HAS_AVX2_CODE

// The pixels that are not green, every other one, in lanes of 16 bits.
template <bool is_green_first>
ROBSIM_AVX2_INLINE __m256i not_green(const std::uint8_t* pixels) {
  const __m256i all = simd::load(pixels);
  return is_green_first ? _mm256_srli_epi16(all, 8)
                        : _mm256_and_si256(all, _mm256_set1_epi16(0x00FF));
}

// Means of 4 for the pixels that are not green, at the places of these, 0 elsewhere.
template <bool is_green_first>
ROBSIM_AVX2_INLINE __m256i means_of_4(const std::uint8_t* a, const std::uint8_t* b,
                                      const std::uint8_t* c, const std::uint8_t* d) {
  const __m256i sum = _mm256_add_epi16(
      _mm256_add_epi16(not_green<is_green_first>(a), not_green<is_green_first>(b)),
      _mm256_add_epi16(not_green<is_green_first>(c), not_green<is_green_first>(d)));
  const __m256i means = _mm256_srli_epi16(_mm256_add_epi16(sum, _mm256_set1_epi16(2)), 2);
  return is_green_first ? _mm256_slli_epi16(means, 8) : means;
}

ROBSIM_AVX2_INLINE __m256i means_of_2(const std::uint8_t* a, const std::uint8_t* b) {
  return _mm256_avg_epu8(simd::load(a), simd::load(b));
}

template <bool is_green_first>
ROBSIM_AVX2_INLINE void debayer_block(const ThreeRows& rows, int u, int own, std::uint8_t* rgb) {
  const std::uint8_t* above = rows.above + u;
  const std::uint8_t* row = rows.row + u;
  const std::uint8_t* below = rows.below + u;
  const __m256i is_green = _mm256_set1_epi16(static_cast<short>(is_green_first ? 0x00FF : 0xFF00));
  const __m256i center = simd::load(row);
  const __m256i of_own = _mm256_blendv_epi8(center, means_of_2(row - 1, row + 1), is_green);
  const __m256i of_green = _mm256_blendv_epi8(
      means_of_4<is_green_first>(row - 1, row + 1, above, below), center, is_green);
  const __m256i of_other =
      _mm256_blendv_epi8(means_of_4<is_green_first>(above - 1, above + 1, below - 1, below + 1),
                         means_of_2(above, below), is_green);
  if (own == 0) {
    store_rgb(of_own, of_green, of_other, rgb);
  } else {
    store_rgb(of_other, of_green, of_own, rgb);
  }
}

template <bool is_green_first>
ROBSIM_AVX2 void bayer_row_avx2(const ThreeRows& rows, int width, int own, std::uint8_t* rgb) {
  int u = 0;
  for (; u + pixels_of_block <= width; u += pixels_of_block) {
    debayer_block<is_green_first>(rows, u, own, rgb + std::ptrdiff_t{3} * u);
  }
  if (u == width) return;
  std::uint8_t result[3 * pixels_of_block];
  debayer_block<is_green_first>(rows, u, own, result);
  std::memcpy(rgb + std::ptrdiff_t{3} * u, result,
              std::size_t{3} * static_cast<std::size_t>(width - u));
}

#endif

template <bool is_green_first>
void bayer_row(const ThreeRows& rows, int width, int own, std::uint8_t* rgb) {
  ROBSIM_PICK(bayer_row_baseline<is_green_first>, bayer_row_avx2<is_green_first>)
  (rows, width, own, rgb);
}

}  // namespace

void convert_bayer(const RawView& raw, const WritableView& rgb) {
  const auto width = static_cast<std::size_t>(raw.width);
  const std::size_t room = width + 2 + pixels_of_block;
  std::vector<std::uint8_t> rows(3 * room);  // each with its mirrored neighbours at both ends
  const auto padded = [&](int v) {
    return rows.data() + room * static_cast<std::size_t>(v % 3) + 1;
  };
  const auto read = [&](int v) {
    std::uint8_t* const row = padded(v);
    std::copy_n(raw.row(v), raw.width, row);
    row[-1] = row[1];  // of the same colour as the pixel that is not there
    row[raw.width] = row[raw.width - 2];
  };
  read(0);
  for (int v = 0; v < raw.height; ++v) {
    const bool is_last = v + 1 == raw.height;
    if (!is_last) read(v + 1);
    const ThreeRows three = {padded(v == 0 ? 1 : v - 1), padded(v),
                             padded(is_last ? v - 1 : v + 1)};
    const char* const colors = raw.format.filter + 2 * (v % 2);
    const bool is_green_first = colors[0] == 'g';
    const int own = colors[is_green_first] == 'r' ? 0 : 2;
    (is_green_first ? bayer_row<true> : bayer_row<false>)(three, raw.width, own, rgb.row(v));
  }
}

}  // namespace robsim::raw
