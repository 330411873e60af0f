#pragma once

#include <string>
#include <vector>

#if defined(__x86_64__) || defined(_M_X64)
#define ROBSIM_HAS_AVX2_CODE 1
#else
#define ROBSIM_HAS_AVX2_CODE 0
#endif

// A function that may use the instructions of AVX2, in a file that is compiled for any processor,
// and one that is made a part of such functions.
#if defined(__GNUC__) || defined(__clang__)
#define ROBSIM_AVX2 __attribute__((target("avx2")))
#define ROBSIM_AVX2_INLINE __attribute__((target("avx2"), always_inline)) inline
#define ROBSIM_INLINE __attribute__((always_inline)) inline
#else
#define ROBSIM_AVX2
#define ROBSIM_AVX2_INLINE __forceinline
#define ROBSIM_INLINE __forceinline
#endif

namespace robsim {

/// The instructions that the hot loops use. All paths give the same results, bit for bit.
enum class CpuPath { baseline, avx2 };

const char* name_of(CpuPath path);

/// The paths that this processor can take, the fastest last.
std::vector<CpuPath> cpu_paths();

/// The path in use: the fastest one, unless another is forced.
CpuPath cpu_path();

/// Throws std::invalid_argument if this processor can't take it.
void force_cpu_path(CpuPath path);

}  // namespace robsim
