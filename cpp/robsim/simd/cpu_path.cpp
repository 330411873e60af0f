#include "robsim/simd/cpu_path.hpp"

#include <algorithm>
#include <atomic>
#include <stdexcept>
#include <string>

#if ROBSIM_HAS_AVX2_CODE && defined(_MSC_VER)
#include <immintrin.h>
#include <intrin.h>
#endif

namespace robsim::simd {

namespace {

#if !ROBSIM_HAS_AVX2_CODE
bool has_avx2() { return false; }
#elif defined(_MSC_VER)
bool has_avx2() {
  int registers[4];
  __cpuidex(registers, 1, 0);
  constexpr int osxsave_and_avx = (1 << 27) | (1 << 28);
  if ((registers[2] & osxsave_and_avx) != osxsave_and_avx) return false;
  if ((_xgetbv(0) & 6) != 6) return false;  // the system saves the AVX registers
  __cpuidex(registers, 7, 0);
  return (registers[1] & (1 << 5)) != 0;
}
#else
bool has_avx2() { return __builtin_cpu_supports("avx2") != 0; }
#endif

std::atomic<CpuPath>& path_in_use() {
  static std::atomic<CpuPath> path{cpu_paths().back()};
  return path;
}

}  // namespace

const char* name_of(CpuPath path) { return path == CpuPath::avx2 ? "avx2" : "baseline"; }

std::vector<CpuPath> cpu_paths() {
  if (has_avx2()) return {CpuPath::baseline, CpuPath::avx2};
  return {CpuPath::baseline};
}

CpuPath cpu_path() { return path_in_use().load(std::memory_order_relaxed); }

void force_cpu_path(CpuPath path) {
  const std::vector<CpuPath> paths = cpu_paths();
  if (std::find(paths.begin(), paths.end(), path) == paths.end()) {
    throw std::invalid_argument(std::string("path is not available on this processor: ") +
                                name_of(path));
  }
  path_in_use().store(path, std::memory_order_relaxed);
}

}  // namespace robsim::simd
