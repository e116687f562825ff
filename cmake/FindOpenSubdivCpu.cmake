# SPDX-License-Identifier: Apache-2.0

# Finds OpenSubdiv's headers and its CPU library: OpenSubdivCpu_FOUND, and the target OpenSubdiv::Cpu.
# OpenSubdiv's own package file cannot be used: on Debian 12 (libosd-dev 3.5.0) it fails, since it refers to a
# static library that is not shipped.
find_path(OpenSubdivCpu_INCLUDE_DIR opensubdiv/version.h)
find_library(OpenSubdivCpu_LIBRARY osdCPU)
mark_as_advanced(OpenSubdivCpu_INCLUDE_DIR OpenSubdivCpu_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenSubdivCpu
  REQUIRED_VARS OpenSubdivCpu_LIBRARY OpenSubdivCpu_INCLUDE_DIR)

if(OpenSubdivCpu_FOUND AND NOT TARGET OpenSubdiv::Cpu)
  add_library(OpenSubdiv::Cpu UNKNOWN IMPORTED)
  set_target_properties(OpenSubdiv::Cpu PROPERTIES
    IMPORTED_LOCATION "${OpenSubdivCpu_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${OpenSubdivCpu_INCLUDE_DIR}")
endif()
