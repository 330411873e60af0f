#pragma once

#include <vector>

#include "robsim/simd/target.hpp"

// The one of two functions that runs on the path in use. A macro, because without AVX2 code the
// name of the second one does not exist.
#if ROBSIM_HAS_AVX2_CODE
#define ROBSIM_PICK(if_baseline, if_avx2) \
  (::robsim::simd::cpu_path() == ::robsim::simd::CpuPath::avx2 ? (if_avx2) : (if_baseline))
#else
#define ROBSIM_PICK(if_baseline, if_avx2) (if_baseline)
#endif

namespace robsim::simd {

/// The instructions that the hot loops use. All paths give the same results, bit for bit.
enum class CpuPath { baseline, avx2 };

const char* name_of(CpuPath path);

/// The paths available on this processor, the fastest last.
std::vector<CpuPath> cpu_paths();

/// The path in use: the fastest one, unless another is forced.
CpuPath cpu_path();

/// Throws std::invalid_argument if the path is not available on this processor.
void force_cpu_path(CpuPath path);

}  // namespace robsim::simd
