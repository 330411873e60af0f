#include "robsim/world/add_noise.hpp"

#include <algorithm>
#include <cstring>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/base/simd/avx.hpp"
#include "robsim/base/simd/cpu_path.hpp"

namespace robsim {

namespace {

constexpr int block = 32;  // bytes at a time

// Applies convert(from, to, first byte) to each block of a row; the last block is a copy.
template <typename Convert>
ROBSIM_INLINE void for_each_block(const std::uint8_t* clean, int bytes, std::uint8_t* noisy,
                                  Convert convert) {
  int i = 0;
  for (; i + block <= bytes; i += block) convert(clean + i, noisy + i, i);
  if (i == bytes) return;
  std::uint8_t last[block] = {0};
  const auto count = static_cast<std::size_t>(bytes - i);
  std::memcpy(last, clean + i, count);
  convert(last, last, i);
  std::memcpy(noisy + i, last, count);
}

// The next block of bits of a stream, of its four generators side by side.
template <typename Number>
ROBSIM_INLINE void draw(std::uint64_t (&state)[4][NoiseStream::lanes], Number* numbers) {
  std::uint64_t bits[NoiseStream::lanes];
  for (int lane = 0; lane < NoiseStream::lanes; ++lane) {
    std::uint64_t s0 = state[0][lane], s1 = state[1][lane];
    std::uint64_t s2 = state[2][lane], s3 = state[3][lane];
    bits[lane] = s0 + s3;
    const std::uint64_t shifted = s1 << 17;
    s2 ^= s0;
    s3 ^= s1;
    state[1][lane] = s1 ^ s2;
    state[0][lane] = s0 ^ s3;
    state[2][lane] = s2 ^ shifted;
    state[3][lane] = (s3 << 45) | (s3 >> 19);
  }
  std::memcpy(numbers, bits, sizeof bits);  // little endian
}

int gaussian_step(std::uint8_t a, std::uint8_t b, std::uint8_t c, const GaussianTables& tables,
                  const NoiseStream& stream, int byte) {
  // a and b: 5 bits each for the triangle, 4 of the others for the column, the last for the sign
  const std::size_t column = (a >> 5) | ((b >> 2) & 8);
  const bool is_own = static_cast<std::int8_t>(c) < tables.threshold[column];
  const std::size_t i = is_own ? column : tables.alias[column];
  if (tables.mask[i] == GaussianTables::tail_mark) return tail_step(stream.rare_bits(byte), tables);
  const int step = tables.node[i] + (a & tables.mask[i]) - (b & tables.mask[i]);
  return (b & 128) != 0 ? -step : step;
}

void add_gaussian_baseline(const std::uint8_t* clean, int bytes, const GaussianTables& tables,
                           NoiseStream& stream, std::uint8_t* noisy) {
  const auto convert = [&](const std::uint8_t* from, std::uint8_t* to, int first) {
    std::uint8_t a[block], b[block], c[block];
    draw(stream.state[0], a);
    draw(stream.state[1], b);
    draw(stream.state[2], c);
    for (int i = 0; i < block; ++i) {
      const int step = gaussian_step(a[i], b[i], c[i], tables, stream, first + i);
      to[i] = static_cast<std::uint8_t>(std::clamp(from[i] + step, 0, 255));
    }
  };
  for_each_block(clean, bytes, noisy, convert);
}

void add_uniform_baseline(const std::uint8_t* clean, int bytes, const UniformSteps& steps,
                          NoiseStream& stream, std::uint8_t* noisy) {
  const auto convert = [&](const std::uint8_t* from, std::uint8_t* to, int) {
    std::uint16_t bits[block];
    draw(stream.state[0], bits);
    draw(stream.state[1], bits + block / 2);
    for (int i = 0; i < block; ++i) {
      const int drawn =
          static_cast<int>((std::uint32_t{bits[i]} * steps.scale) >> 16) + steps.offset;
      // A shift of a negative number rounds down, as the AVX2 instruction does.
      const int step = (drawn >> steps.shift) * (1 << steps.doublings);
      to[i] = static_cast<std::uint8_t>(std::clamp(from[i] + step, 0, 255));
    }
  };
  for_each_block(clean, bytes, noisy, convert);
}

#if ROBSIM_HAS_AVX2_CODE

// --- 32 bytes at a time

// Four generators, one in each quarter of the registers.
struct Generators {
  __m256i s0;
  __m256i s1;
  __m256i s2;
  __m256i s3;
};

ROBSIM_AVX2_INLINE Generators generators_from(const std::uint64_t (&state)[4][NoiseStream::lanes]) {
  return {simd::load(state[0]), simd::load(state[1]), simd::load(state[2]), simd::load(state[3])};
}

ROBSIM_AVX2_INLINE void keep(const Generators& s, std::uint64_t (&state)[4][NoiseStream::lanes]) {
  simd::store(s.s0, state[0]);
  simd::store(s.s1, state[1]);
  simd::store(s.s2, state[2]);
  simd::store(s.s3, state[3]);
}

ROBSIM_AVX2_INLINE __m256i draw(Generators& s) {
  const __m256i bits = _mm256_add_epi64(s.s0, s.s3);
  const __m256i shifted = _mm256_slli_epi64(s.s1, 17);
  s.s2 = _mm256_xor_si256(s.s2, s.s0);
  s.s3 = _mm256_xor_si256(s.s3, s.s1);
  s.s1 = _mm256_xor_si256(s.s1, s.s2);
  s.s0 = _mm256_xor_si256(s.s0, s.s3);
  s.s2 = _mm256_xor_si256(s.s2, shifted);
  s.s3 = _mm256_or_si256(_mm256_slli_epi64(s.s3, 45), _mm256_srli_epi64(s.s3, 19));
  return bits;
}

template <typename T>
ROBSIM_AVX2_INLINE __m256i table(const std::array<T, 16>& values) {
  return simd::load_halves(values.data(), values.data());
}

struct RegisterTables {
  __m256i threshold;
  __m256i change;  // alias xor column
  __m256i node;
  __m256i mask;
};

struct WithGaussian {
  __m256i sum;
  std::uint32_t tails;  // bit i: byte i is to be drawn from the tail
};

ROBSIM_AVX2_INLINE WithGaussian with_gaussian(__m256i value, __m256i a, __m256i b, __m256i c,
                                              const RegisterTables& tables) {
  const __m256i low = _mm256_and_si256(_mm256_srli_epi16(a, 5), _mm256_set1_epi8(7));
  const __m256i high = _mm256_and_si256(_mm256_srli_epi16(b, 2), _mm256_set1_epi8(8));
  const __m256i column = _mm256_or_si256(low, high);
  const __m256i is_own = _mm256_cmpgt_epi8(_mm256_shuffle_epi8(tables.threshold, column), c);
  const __m256i i = _mm256_xor_si256(
      column, _mm256_andnot_si256(is_own, _mm256_shuffle_epi8(tables.change, column)));
  const __m256i mask = _mm256_shuffle_epi8(tables.mask, i);
  const __m256i node = _mm256_shuffle_epi8(tables.node, i);
  const __m256i u1 = _mm256_and_si256(a, mask);
  const __m256i u2 = _mm256_and_si256(b, mask);
  // step = more - less, one of which is 0
  const __m256i up = _mm256_adds_epu8(node, _mm256_subs_epu8(u1, u2));
  const __m256i down = _mm256_subs_epu8(u2, u1);
  const __m256i more = _mm256_subs_epu8(up, down);
  const __m256i less = _mm256_subs_epu8(down, up);
  // value - step = 255 - ((255 - value) + step)
  const __m256i flip = _mm256_cmpgt_epi8(_mm256_setzero_si256(), b);
  const __m256i sum = _mm256_adds_epu8(_mm256_xor_si256(value, flip), more);
  return {_mm256_xor_si256(_mm256_subs_epu8(sum, less), flip),
          static_cast<std::uint32_t>(_mm256_movemask_epi8(mask))};
}

// The blocks with bytes that come from the tail: these are drawn after the others, since a call
// within the loop would cost it its registers.
struct TailBlocks {
  static constexpr int maximum = 64;

  alignas(32) std::uint8_t clean[maximum][block];
  std::uint32_t tails[maximum];
  int first[maximum];  // byte of the row
  int count;
};

void draw_tails(const TailBlocks& blocks, const GaussianTables& tables, const NoiseStream& stream,
                int bytes, std::uint8_t* noisy) {
  for (int b = 0; b < blocks.count; ++b) {
    int i = 0;
    for (std::uint32_t tails = blocks.tails[b]; tails != 0; tails >>= 1, ++i) {
      const int byte = blocks.first[b] + i;
      if ((tails & 1) == 0 || byte >= bytes) continue;
      const int value = blocks.clean[b][i] + tail_step(stream.rare_bits(byte), tables);
      noisy[byte] = static_cast<std::uint8_t>(std::clamp(value, 0, 255));
    }
  }
}

ROBSIM_AVX2_INLINE __m256i with_uniform(__m256i value, __m256i a, __m256i b,
                                        const UniformSteps& steps) {
  const __m256i scale = _mm256_set1_epi16(static_cast<short>(steps.scale));
  const __m256i offset = _mm256_set1_epi16(steps.offset);
  const __m128i shift = _mm_cvtsi32_si128(steps.shift);
  const auto step = [&](__m256i bits) ROBSIM_AVX2 {
    const __m256i drawn = _mm256_add_epi16(_mm256_mulhi_epu16(bits, scale), offset);
    __m256i result = _mm256_sra_epi16(drawn, shift);
    for (int i = 0; i < steps.doublings; ++i) result = _mm256_adds_epi16(result, result);
    return result;
  };
  const __m256i low = _mm256_cvtepu8_epi16(_mm256_castsi256_si128(value));
  const __m256i high = _mm256_cvtepu8_epi16(_mm256_extracti128_si256(value, 1));
  return simd::in_order(
      _mm256_packus_epi16(_mm256_adds_epi16(low, step(a)), _mm256_adds_epi16(high, step(b))));
}

ROBSIM_AVX2_INLINE void add_gaussian_blocks(const std::uint8_t* clean, int bytes,
                                            const GaussianTables& tables, NoiseStream& stream,
                                            std::uint8_t* noisy) {
  std::array<std::uint8_t, 16> change;
  for (std::size_t k = 0; k < 16; ++k) change[k] = static_cast<std::uint8_t>(tables.alias[k] ^ k);
  const RegisterTables registers = {table(tables.threshold), table(change), table(tables.node),
                                    table(tables.mask)};
  Generators a = generators_from(stream.state[0]);
  Generators b = generators_from(stream.state[1]);
  Generators c = generators_from(stream.state[2]);
  constexpr int part = block * TailBlocks::maximum;
  TailBlocks blocks;
  for (int begin = 0; begin < bytes; begin += part) {
    int found = 0;
    const int count = std::min(part, bytes - begin);
    const auto convert = [&](const std::uint8_t* from, std::uint8_t* to, int i) ROBSIM_AVX2 {
      const __m256i value = simd::load(from);
      const WithGaussian result = with_gaussian(value, draw(a), draw(b), draw(c), registers);
      if (result.tails != 0) {
        simd::store(value, blocks.clean[found]);
        blocks.tails[found] = result.tails;
        blocks.first[found++] = begin + i;
      }
      simd::store(result.sum, to);
    };
    for_each_block(clean + begin, count, noisy + begin, convert);
    blocks.count = found;
    draw_tails(blocks, tables, stream, bytes, noisy);
  }
  keep(a, stream.state[0]);
  keep(b, stream.state[1]);
  keep(c, stream.state[2]);
}

ROBSIM_AVX2_INLINE void add_uniform_blocks(const std::uint8_t* clean, int bytes,
                                           const UniformSteps& steps, NoiseStream& stream,
                                           std::uint8_t* noisy) {
  Generators a = generators_from(stream.state[0]);
  Generators b = generators_from(stream.state[1]);
  const auto convert = [&](const std::uint8_t* from, std::uint8_t* to, int) ROBSIM_AVX2 {
    simd::store(with_uniform(simd::load(from), draw(a), draw(b), steps), to);
  };
  for_each_block(clean, bytes, noisy, convert);
  keep(a, stream.state[0]);
  keep(b, stream.state[1]);
}

#endif

}  // namespace

NoiseStream::NoiseStream(std::uint64_t seed, std::uint64_t index) {
  const std::uint64_t key = random_bits(seed, index);
  std::uint64_t counter = 0;
  for (auto& generator : state) {
    for (auto& word : generator) {
      for (std::uint64_t& lane : word) lane = random_bits(key, counter++);
    }
  }
  rare_key = random_bits(key, counter);
}

std::uint64_t NoiseStream::rare_bits(int i) const {
  return random_bits(rare_key, bytes_done + static_cast<std::uint64_t>(i));
}

void add_gaussian(const std::uint8_t* clean, int bytes, const GaussianTables& tables,
                  NoiseStream& stream, std::uint8_t* noisy) {
  // The text is the same for both paths: with AVX-512 the compiler has rotations, logic of three
  // operands and twice as many registers. Registers of 64 bytes gain nothing, as the streams come
  // in draws of 32.
  ROBSIM_PICK(add_gaussian_baseline, add_gaussian_blocks, add_gaussian_blocks)
  (clean, bytes, tables, stream, noisy);
  stream.bytes_done += static_cast<std::uint64_t>(bytes);
}

void add_uniform(const std::uint8_t* clean, int bytes, const UniformSteps& steps,
                 NoiseStream& stream, std::uint8_t* noisy) {
  ROBSIM_PICK(add_uniform_baseline, add_uniform_blocks, add_uniform_blocks)
  (clean, bytes, steps, stream, noisy);
}

}  // namespace robsim
