#pragma once

#if defined(__x86_64__) || defined(_M_X64)
#define ROBSIM_HAS_AVX2_CODE 1
#define ROBSIM_HAS_AVX512_CODE 1
#else
#define ROBSIM_HAS_AVX2_CODE 0
#define ROBSIM_HAS_AVX512_CODE 0
#endif

// ROBSIM_AVX2 and ROBSIM_AVX512 mark a function that may use these instructions in a file that is
// compiled for any processor, ROBSIM_AVX2_INLINE and ROBSIM_AVX512_INLINE one that is inlined into
// such functions, ROBSIM_INLINE one that is compiled for the processor of its caller.
#if defined(__GNUC__) || defined(__clang__)
#define ROBSIM_TARGET_AVX2 target("avx2")
#define ROBSIM_TARGET_AVX512 \
  target("avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,prefer-vector-width=512")
#define ROBSIM_AVX2 __attribute__((ROBSIM_TARGET_AVX2))
#define ROBSIM_AVX512 __attribute__((ROBSIM_TARGET_AVX512))
#define ROBSIM_AVX2_INLINE __attribute__((ROBSIM_TARGET_AVX2, always_inline)) inline
#define ROBSIM_AVX512_INLINE __attribute__((ROBSIM_TARGET_AVX512, always_inline)) inline
#define ROBSIM_INLINE __attribute__((always_inline)) inline
#else
#define ROBSIM_AVX2
#define ROBSIM_AVX512
#define ROBSIM_AVX2_INLINE __forceinline
#define ROBSIM_AVX512_INLINE __forceinline
#define ROBSIM_INLINE __forceinline
#endif

// Before a loop with a small trip count that is known at compile time.
#if defined(__clang__)
#define ROBSIM_UNROLL _Pragma("unroll")
#elif defined(__GNUC__)
#define ROBSIM_UNROLL _Pragma("GCC unroll 8")
#else
#define ROBSIM_UNROLL
#endif
