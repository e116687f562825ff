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

#define __MMINTRIN_H                   // emscripten has no MMX, and Eigen uses none of it
#define EIGEN_OPTIMIZATION_BARRIER(x)  // assembly of x86-64, for -ffast-math alone
// Without this macro, Eigen uses intrinsic functions where GCC before 6.3 needed assembly of
// x86-64.
#pragma push_macro("__GNUC__")
#undef __GNUC__
#include <Eigen/Core>
#pragma pop_macro("__GNUC__")

#endif
