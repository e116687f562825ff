# SPDX-License-Identifier: Apache-2.0

# Finds a PETSc with real double scalars, by its pkg-config file, and the MPI that it is built on:
# PetscReal_FOUND, and the target PetscReal::petsc. Integers may have either size.
#
# If a PETSc exists but cannot be used, prints the reason, even under QUIET.

# Repeats checks that failed before, since another PETSc may have been installed.
if(NOT PetscReal_SCALARS_ARE_DOUBLE)
  unset(PetscReal_SCALARS_ARE_DOUBLE CACHE)
  unset(PetscReal_PC_FOUND CACHE)
endif()
find_package(PkgConfig QUIET)
find_package(MPI QUIET COMPONENTS CXX)
if(PKG_CONFIG_FOUND)
  pkg_check_modules(PetscReal_PC QUIET IMPORTED_TARGET GLOBAL PETSc)
endif()
# Drops the options with which Debian compiled PETSc: -D_FORTIFY_SOURCE=2 warns in builds without
# optimization.
if(TARGET PkgConfig::PetscReal_PC)
  set_target_properties(PkgConfig::PetscReal_PC PROPERTIES INTERFACE_COMPILE_OPTIONS "")
endif()

# Checks the type of the scalars. Each build of PETSc has only one.
if(PetscReal_PC_FOUND AND MPI_CXX_FOUND)
  include(CheckCXXSourceCompiles)
  include(CMakePushCheckState)
  cmake_push_check_state(RESET)
  set(CMAKE_REQUIRED_LIBRARIES PkgConfig::PetscReal_PC MPI::MPI_CXX)
  check_cxx_source_compiles("
    #include <petscmat.h>
    static_assert(static_cast<PetscScalar*>(nullptr) == static_cast<double*>(nullptr));
    int main() { return PetscFinalize() == 0 ? 0 : 1; }" PetscReal_SCALARS_ARE_DOUBLE)
  cmake_pop_check_state()
endif()

unset(PetscReal_unfit)
if(PetscReal_PC_FOUND AND PetscReal_PC_VERSION VERSION_LESS PetscReal_FIND_VERSION)
  set(PetscReal_unfit "${PetscReal_FIND_VERSION} or later is needed")
elseif(PetscReal_PC_FOUND AND NOT MPI_CXX_FOUND)
  set(PetscReal_unfit "the MPI of its C++ programs is not found")
elseif(PetscReal_PC_FOUND AND NOT PetscReal_SCALARS_ARE_DOUBLE)
  set(PetscReal_unfit "its scalars are not real doubles, or no program links with it")
endif()
if(PetscReal_unfit)
  message(STATUS "PETSc ${PetscReal_PC_VERSION} cannot be used: ${PetscReal_unfit}")
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(PetscReal
  REQUIRED_VARS PetscReal_PC_FOUND MPI_CXX_FOUND PetscReal_SCALARS_ARE_DOUBLE
  VERSION_VAR PetscReal_PC_VERSION)

if(PetscReal_FOUND AND NOT TARGET PetscReal::petsc)
  add_library(PetscReal::petsc INTERFACE IMPORTED)
  set_target_properties(PetscReal::petsc PROPERTIES
    INTERFACE_LINK_LIBRARIES "PkgConfig::PetscReal_PC;MPI::MPI_CXX")
endif()
