// SPDX-License-Identifier: Apache-2.0
// Eigen with its vectors for SSE2, which emscripten translates to the vectors of WebAssembly. Eigen
// adds three numbers as (a + b) + c with vectors, and as a + (b + c) without: with them, the
// results have the bits of the builds for x86-64. EspalierWasm.cmake includes this file before each
// source that uses Eigen.
#if !defined(ESPALIER_WASM_EIGEN_H) && defined(__cplusplus)
#define ESPALIER_WASM_EIGEN_H

#include <emmintrin.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <sstream>
#include <string>
#include <type_traits>

namespace espalier::wasm {

// Clang 14 joins a load and the copy of its number to all lanes to one instruction, and forgets
// that the load must come before later stores: p = M * p then reads numbers of p that are new
// already. An empty assembly statement between the two keeps them apart.
inline __m128d inAllLanes(double number) {
    __asm__("" : "+r"(number));
    return __m128d{number, number};
}

inline __m128 inAllLanes(float number) {
    __asm__("" : "+r"(number));
    return __m128{number, number, number, number};
}

inline __m128 inFirstLane(float number) {
    __asm__("" : "+r"(number));
    return __m128{number, 0, 0, 0};
}

}  // namespace espalier::wasm
#undef _mm_set1_pd
#undef _mm_set1_ps
#undef _mm_set_pd1
#undef _mm_set_ps1
#undef _mm_load1_pd
#undef _mm_load1_ps
#undef _mm_load_ss
#define _mm_set1_pd(number) espalier::wasm::inAllLanes(static_cast<double>(number))
#define _mm_set1_ps(number) espalier::wasm::inAllLanes(static_cast<float>(number))
#define _mm_set_pd1(number) _mm_set1_pd(number)
#define _mm_set_ps1(number) _mm_set1_ps(number)
#define _mm_load1_pd(from) _mm_set1_pd(*(from))
#define _mm_load1_ps(from) _mm_set1_ps(*(from))
#define _mm_load_ss(from) espalier::wasm::inFirstLane(*(from))

#define __MMINTRIN_H                   // emscripten has no MMX, and Eigen uses none of it
#define EIGEN_OPTIMIZATION_BARRIER(x)  // assembly of x86-64, for -ffast-math alone
// Without this macro, Eigen uses intrinsic functions where GCC before 6.3 needed assembly of
// x86-64.
#pragma push_macro("__GNUC__")
#undef __GNUC__
#include <Eigen/Core>
#pragma pop_macro("__GNUC__")

#endif
