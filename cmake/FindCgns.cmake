# SPDX-License-Identifier: Apache-2.0

# Finds CGNS's library, for which Debian has no package file, and HDF5's library, which it uses (Debian has a serial
# one for it, and others for MPI): Cgns_FOUND, and the target Cgns::cgns.
find_path(Cgns_INCLUDE_DIR cgnslib.h)
find_library(Cgns_LIBRARY cgns)
find_path(Cgns_HDF5_INCLUDE_DIR hdf5.h PATH_SUFFIXES hdf5/serial)
find_library(Cgns_HDF5_LIBRARY NAMES hdf5_serial hdf5)
mark_as_advanced(Cgns_INCLUDE_DIR Cgns_LIBRARY Cgns_HDF5_INCLUDE_DIR Cgns_HDF5_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Cgns REQUIRED_VARS
  Cgns_LIBRARY Cgns_INCLUDE_DIR Cgns_HDF5_LIBRARY Cgns_HDF5_INCLUDE_DIR)

if(Cgns_FOUND AND NOT TARGET Cgns::cgns)
  add_library(Cgns::cgns UNKNOWN IMPORTED)
  set_target_properties(Cgns::cgns PROPERTIES
    IMPORTED_LOCATION "${Cgns_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${Cgns_INCLUDE_DIR};${Cgns_HDF5_INCLUDE_DIR}"
    INTERFACE_LINK_LIBRARIES "${Cgns_HDF5_LIBRARY}")
endif()
