#include "robsim/base/simd/cpu_path.hpp"

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
bool has_avx512() { return false; }
#elif defined(_MSC_VER)
// Of leaf 7 of CPUID. AVX is there, and the system saves these registers (a mask of XCR0).
bool has_features(int saved_registers, int in_ebx, int in_ecx) {
  int registers[4];
  __cpuidex(registers, 0, 0);
  if (registers[0] < 7) return false;
  __cpuidex(registers, 1, 0);
  constexpr int osxsave_and_avx = (1 << 27) | (1 << 28);
  if ((registers[2] & osxsave_and_avx) != osxsave_and_avx) return false;
  if ((_xgetbv(0) & saved_registers) != saved_registers) return false;
  __cpuidex(registers, 7, 0);
  return (registers[1] & in_ebx) == in_ebx && (registers[2] & in_ecx) == in_ecx;
}

bool has_avx2() { return has_features(0x6, 1 << 5, 0); }

bool has_avx512() {
  constexpr int f_dq_bw_vl = (1 << 16) | (1 << 17) | (1 << 30) | static_cast<int>(1U << 31);
  constexpr int vbmi = 1 << 1;
  return has_avx2() && has_features(0xE6, f_dq_bw_vl, vbmi);
}
#else
// These ask whether the system saves the registers, too.
bool has_avx2() { return __builtin_cpu_supports("avx2") != 0; }

bool has_avx512() {
  return has_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
         __builtin_cpu_supports("avx512vbmi");
}
#endif

std::atomic<CpuPath>& path_in_use() {
  static std::atomic<CpuPath> path{cpu_paths().back()};
  return path;
}

}  // namespace

const char* name_of(CpuPath path) {
  if (path == CpuPath::avx512) return "avx512";
  return path == CpuPath::avx2 ? "avx2" : "baseline";
}

std::vector<CpuPath> cpu_paths() {
  std::vector<CpuPath> paths = {CpuPath::baseline};
  if (has_avx2()) paths.push_back(CpuPath::avx2);
  if (has_avx512()) paths.push_back(CpuPath::avx512);
  return paths;
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
