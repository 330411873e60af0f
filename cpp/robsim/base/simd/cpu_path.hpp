#pragma once

#include <vector>

#include "robsim/base/simd/target.hpp"

// The one of two or three functions that runs on the path in use: for any processor, with AVX2 and,
// if there is a third one, with AVX-512. A macro, because elsewhere than on x86-64 the names of the
// others do not exist.
#if ROBSIM_HAS_AVX2_CODE
#define ROBSIM_PICK(if_baseline, ...) ::robsim::simd::pick((if_baseline), __VA_ARGS__)
#else
#define ROBSIM_PICK(if_baseline, ...) (if_baseline)
#endif

namespace robsim::simd {

/// The instructions that the hot loops use. All paths give the same results, bit for bit.
/// avx512: F, BW, DQ, VL and VBMI, as processors from 2019 on have them.
enum class CpuPath { baseline, avx2, avx512 };

const char* name_of(CpuPath path);

/// The paths available on this processor, the fastest last.
std::vector<CpuPath> cpu_paths();

/// The path in use: the fastest one, unless another is forced.
CpuPath cpu_path();

/// Throws std::invalid_argument if the path is not available on this processor.
void force_cpu_path(CpuPath path);

template <typename F>
F pick(F if_baseline, F if_avx2, F if_avx512) {
  const CpuPath path = cpu_path();
  if (path == CpuPath::avx512) return if_avx512;
  return path == CpuPath::avx2 ? if_avx2 : if_baseline;
}

template <typename F>
F pick(F if_baseline, F if_avx2) {
  return pick(if_baseline, if_avx2, if_avx2);
}

}  // namespace robsim::simd
