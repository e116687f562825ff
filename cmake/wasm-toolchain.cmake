# SPDX-License-Identifier: Apache-2.0
# The toolchain of the preset wasm: Debian's emscripten, with WebAssembly's own exceptions and 128-bit vectors.
# Exceptions that go through JavaScript (-fexceptions) make every call that may throw 20 times slower. The
# vectorizers of clang 14 miscompile loops over doubles for WebAssembly (TricubicPatch.WeightsAndControlPointsAgree
# fails); the kernels of osd/ use vectors by name, and need none.
set(CMAKE_CXX_FLAGS_INIT
    "-fwasm-exceptions -msimd128 -include ${CMAKE_CURRENT_LIST_DIR}/wasm-standard-library.h")
set(CMAKE_C_FLAGS_INIT "-msimd128")
foreach(language C CXX)  # after -O3, which switches them on
  set(CMAKE_${language}_FLAGS_RELEASE "-O3 -DNDEBUG -fno-vectorize -fno-slp-vectorize" CACHE STRING "")
endforeach()
find_path(emscripten_cmake Modules/Platform/Emscripten.cmake
          HINTS $ENV{EMSCRIPTEN}/cmake /usr/share/emscripten/cmake REQUIRED NO_CMAKE_FIND_ROOT_PATH)
include(${emscripten_cmake}/Modules/Platform/Emscripten.cmake)
# Tests run under Node.js. Emscripten 3.1.6 would load programs by fetch(), which Node.js has since version 18,
# and which reads no files.
set(CMAKE_CROSSCOMPILING_EMULATOR "node;--no-experimental-fetch")
