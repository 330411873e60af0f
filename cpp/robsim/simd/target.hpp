#pragma once

#if defined(__x86_64__) || defined(_M_X64)
#define ROBSIM_HAS_AVX2_CODE 1
#else
#define ROBSIM_HAS_AVX2_CODE 0
#endif

// ROBSIM_AVX2 marks a function that may use AVX2 in a file that is compiled for any processor,
// ROBSIM_AVX2_INLINE one that is inlined into such functions, ROBSIM_INLINE one that is compiled
// for the processor of its caller.
#if defined(__GNUC__) || defined(__clang__)
#define ROBSIM_AVX2 __attribute__((target("avx2")))
#define ROBSIM_AVX2_INLINE __attribute__((target("avx2"), always_inline)) inline
#define ROBSIM_INLINE __attribute__((always_inline)) inline
#else
#define ROBSIM_AVX2
#define ROBSIM_AVX2_INLINE __forceinline
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
