# SPDX-License-Identifier: Apache-2.0
# Looks for a CUDA compiler. Sets ESPALIER_CUDA_FOUND, and provides the run-time library as
# CUDA::cudart_static.
include_guard(GLOBAL)
include(CheckLanguage)

# Code for GPUs from Turing to Hopper, and PTX, which drivers compile for later ones.
if(NOT DEFINED CMAKE_CUDA_ARCHITECTURES)
  set(CMAKE_CUDA_ARCHITECTURES 75-real 80-real 86-real 89-real 90)
endif()
set(ESPALIER_CUDA_FOUND FALSE)
check_language(CUDA)
if(CMAKE_CUDA_COMPILER)
  enable_language(CUDA)
  find_package(CUDAToolkit QUIET)
  # CUDA before version 12 has no C++20.
  if(CUDAToolkit_FOUND AND CMAKE_CUDA_COMPILER_VERSION VERSION_GREATER_EQUAL 12)
    set(ESPALIER_CUDA_FOUND TRUE)
  endif()
endif()
# Sets the options with which the CUDA sources of our targets are compiled. Not by CUDA_STANDARD: CMake 3.25
# does not know that CUDA 12 supports C++20.
function(espalier_cuda_options target)
  set_target_properties(${target} PROPERTIES CUDA_RUNTIME_LIBRARY Static)
  set(options -std=c++20 $<$<BOOL:${ESPALIER_WARNINGS_AS_ERRORS}>:-Werror=all-warnings>)
  target_compile_options(${target} PRIVATE "$<$<COMPILE_LANGUAGE:CUDA>:${options}>")
endfunction()

if(NOT ESPALIER_CUDA_FOUND)
  message(STATUS "CUDA 12 or later not found: Espalier evaluates on processors alone")
endif()
