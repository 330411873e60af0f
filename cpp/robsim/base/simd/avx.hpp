#pragma once

#include "robsim/base/simd/target.hpp"

#if ROBSIM_HAS_AVX512_CODE

// gcc 12 warns of registers that its own intrinsics leave undefined on purpose.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif

namespace robsim::simd {

/// 64 bytes from memory of any alignment.
template <typename T>
ROBSIM_AVX512_INLINE __m512i load_wide(const T* values) {
  return _mm512_loadu_si512(values);
}

template <typename T>
ROBSIM_AVX512_INLINE void store(__m512i vector, T* values) {
  _mm512_storeu_si512(values, vector);
}

}  // namespace robsim::simd

#endif

#if ROBSIM_HAS_AVX2_CODE

namespace robsim::simd {

/// 32 bytes from memory of any alignment.
template <typename T>
ROBSIM_AVX2_INLINE __m256i load(const T* values) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(values));
}

template <typename T>
ROBSIM_AVX2_INLINE void store(__m256i vector, T* values) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(values), vector);
}

/// 16 bytes in each half of a register.
template <typename T>
ROBSIM_AVX2_INLINE __m256i load_halves(const T* low, const T* high) {
  const __m128i a = _mm_loadu_si128(reinterpret_cast<const __m128i*>(low));
  const __m128i b = _mm_loadu_si128(reinterpret_cast<const __m128i*>(high));
  return _mm256_inserti128_si256(_mm256_castsi128_si256(a), b, 1);
}

/// Undoes what the pack instructions do to the order: they work within the halves of a register.
ROBSIM_AVX2_INLINE __m256i in_order(__m256i packed) {
  return _mm256_permute4x64_epi64(packed, 0b11011000);
}

}  // namespace robsim::simd

#endif
