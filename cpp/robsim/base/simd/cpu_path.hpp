#pragma once

#include <vector>

#include "robsim/base/simd/target.hpp"

// The function that runs on the path in use, of one to three texts: for any processor, with AVX2
// and, if there is a third one, with AVX-512. A missing second text is the first one, which must be
// ROBSIM_INLINE: the compiler optimises it for each path. A macro, because elsewhere
// than on x86-64 the names of the others do not exist.
#if ROBSIM_HAS_AVX2_CODE
#define ROBSIM_PICK(...) ::robsim::simd::pick<__VA_ARGS__>()
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

/// A text compiled for each path.
template <auto text, typename Function = decltype(text)>
struct CompiledText;

template <auto text, typename Result, typename... A>
struct CompiledText<text, Result (*)(A...)> {
  static Result for_any(A... arguments) { return text(arguments...); }
  static ROBSIM_AVX2 Result for_avx2(A... arguments) { return text(arguments...); }
  static ROBSIM_AVX512 Result for_avx512(A... arguments) { return text(arguments...); }
};

template <auto if_baseline, auto if_avx2 = if_baseline, auto... if_avx512>
auto pick() {
  const CpuPath path = cpu_path();
  if constexpr (sizeof...(if_avx512) == 1) {
    if (path == CpuPath::avx512) return &CompiledText<if_avx512...>::for_avx512;
  }
  return path == CpuPath::baseline ? &CompiledText<if_baseline>::for_any
                                   : &CompiledText<if_avx2>::for_avx2;
}

}  // namespace robsim::simd
