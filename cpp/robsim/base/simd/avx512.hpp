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
