# SPDX-License-Identifier: Apache-2.0
include(GNUInstallDirs)

# Below 1.0, versions with different minor numbers are not compatible (SemVer, 4).
if(PROJECT_VERSION_MAJOR EQUAL 0)
  set(ESPALIER_SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
else()
  set(ESPALIER_SOVERSION ${PROJECT_VERSION_MAJOR})
endif()

# A preset may take the libraries of ESPALIER_PREBUILT from the build folder ESPALIER_PREBUILT_IN, instead of
# compiling them too. They are brought up to date there first.
if(ESPALIER_PREBUILT)
  if(NOT EXISTS ${ESPALIER_PREBUILT_IN}/build.ninja)
    cmake_path(GET ESPALIER_PREBUILT_IN FILENAME preset)
    message(FATAL_ERROR "${ESPALIER_PREBUILT_IN} is missing: run scripts/build ${preset} first")
  endif()
  set(names ${ESPALIER_PREBUILT})
  list(TRANSFORM names PREPEND espalier_)
  list(TRANSFORM ESPALIER_PREBUILT REPLACE "(.+)" "${ESPALIER_PREBUILT_IN}/\\1/libespalier_\\1.a"
       OUTPUT_VARIABLE files)
  add_custom_target(espalier_prebuilt COMMAND ${CMAKE_COMMAND} --build ${ESPALIER_PREBUILT_IN} --target ${names}
                    BYPRODUCTS ${files} VERBATIM)
endif()

# espalier_library(NAME [FOLDER name] HEADERS ... [INTERNAL ...] SOURCES ... DEPENDS ...)
#
# Adds the library of a folder, which is one component of the package: espalier_NAME, with the alias
# espalier::NAME. HEADERS are the public headers, which users need and which are installed; INTERNAL are headers for
# other folders of this repository, which are not installed; private headers are among the SOURCES. Public and
# internal headers are included as <espalier/FOLDER/header.h>; FOLDER is NAME by default. The include path has a
# link to each of them, of this library and of the libraries that it depends on, and nothing else. So no other folder
# can include a private header, and no include can go against the data flow.
function(espalier_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "FOLDER" "HEADERS;INTERNAL;SOURCES;DEPENDS")
  set(target espalier_${name})
  if(NOT arg_FOLDER)
    set(arg_FOLDER ${name})
  endif()
  if(name IN_LIST ESPALIER_PREBUILT)
    set(arg_SOURCES ${PROJECT_BINARY_DIR}/empty.cpp)
    file(CONFIGURE OUTPUT ${arg_SOURCES} CONTENT "")
  endif()
  add_library(${target} ${arg_SOURCES})
  add_library(espalier::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES
    EXPORT_NAME ${name} VERSION ${PROJECT_VERSION} SOVERSION ${ESPALIER_SOVERSION}
    POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  get_target_property(type ${target} TYPE)
  if(type STREQUAL STATIC_LIBRARY)
    target_compile_definitions(${target} PRIVATE ESPALIER_STATIC)
  endif()

  set(include_dir ${PROJECT_BINARY_DIR}/include/${name})
  file(REMOVE_RECURSE ${include_dir})
  foreach(header IN LISTS arg_HEADERS arg_INTERNAL)
    cmake_path(GET header PARENT_PATH inner)
    file(MAKE_DIRECTORY ${include_dir}/espalier/${arg_FOLDER}/${inner})
    file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR}/${header}
                     ${include_dir}/espalier/${arg_FOLDER}/${header} SYMBOLIC)
  endforeach()
  target_sources(${target} PRIVATE ${arg_HEADERS} ${arg_INTERNAL})
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${include_dir}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  set_property(GLOBAL PROPERTY ESPALIER_${name}_FOLDER ${arg_FOLDER})
  set_property(GLOBAL PROPERTY ESPALIER_${name}_HEADERS ${arg_HEADERS})
  foreach(dependency IN LISTS arg_DEPENDS)
    target_link_libraries(${target} PUBLIC espalier::${dependency})
  endforeach()
  espalier_compile_options(${target})
  # Results must not depend on whether a processor can fuse products. The kernels of osd fuse explicitly.
  target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-ffp-contract=off>)
  if(name IN_LIST ESPALIER_PREBUILT)
    add_library(${target}_prebuilt STATIC IMPORTED GLOBAL)
    set_target_properties(${target}_prebuilt PROPERTIES
      IMPORTED_LOCATION ${ESPALIER_PREBUILT_IN}/${name}/lib${target}.a)
    list(TRANSFORM arg_DEPENDS PREPEND espalier:: OUTPUT_VARIABLE dependencies)
    target_link_libraries(${target}_prebuilt INTERFACE ${dependencies})
    target_link_libraries(${target} PUBLIC ${target}_prebuilt)
    add_dependencies(${target}_prebuilt espalier_prebuilt)
  endif()
  set_property(GLOBAL APPEND PROPERTY ESPALIER_COMPONENTS ${name})
  set_property(GLOBAL PROPERTY ESPALIER_${name}_DEPENDS ${arg_DEPENDS})
endfunction()

# Sets the options with which our targets are compiled. Users of the libraries inherit only C++20.
function(espalier_compile_options target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF)
  # Clang's -Wconversion also warns about signed indices in brackets; GCC's does not in C++.
  set(options -Wall -Wextra -Wpedantic -Wconversion -Wshadow
              $<$<CXX_COMPILER_ID:Clang>:-Wno-sign-conversion>
              # On a machine of 32 bits, every index of 64 bits into an array would warn.
              $<$<AND:$<CXX_COMPILER_ID:Clang>,$<EQUAL:${CMAKE_SIZEOF_VOID_P},4>>:-Wno-shorten-64-to-32>
              # In a unity build GCC takes every source for a header.
              $<$<AND:$<CXX_COMPILER_ID:GNU>,$<BOOL:${CMAKE_UNITY_BUILD}>>:-Wno-subobject-linkage>
              $<$<BOOL:${ESPALIER_WARNINGS_AS_ERRORS}>:-Werror>)
  if(ESPALIER_LARGE_COMPILER_HEAP AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # A preset's choice: a compiler that may use 1.5 GB before it looks for free memory takes a tenth less time.
    list(APPEND options --param=ggc-min-expand=300 --param=ggc-min-heapsize=1500000)
  endif()
  cmake_path(RELATIVE_PATH CMAKE_CURRENT_SOURCE_DIR BASE_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE folder)
  if(folder IN_LIST ESPALIER_UNOPTIMIZED)
    list(APPEND options -O0)  # a preset's choice: optimizing takes longer than it saves in the tests
  endif()
  target_compile_options(${target} PRIVATE "$<$<COMPILE_LANGUAGE:CXX>:${options}>")
endfunction()

# espalier_uses(NAME PUBLIC|PRIVATE TARGET PACKAGE name PKG_CONFIG name|-lname|-Lfolder... DEBIAN name)
#
# Links a component to an external library, and records the names of that library for find_package, for
# pkg-config (if it has one) and for apt. Users of the component must find the library too, unless it is
# private to a shared library.
function(espalier_uses name scope library)
  cmake_parse_arguments(PARSE_ARGV 3 arg "" "PACKAGE" "PKG_CONFIG;DEBIAN")
  target_link_libraries(espalier_${name} ${scope} ${library})
  get_target_property(type espalier_${name} TYPE)
  if(scope STREQUAL PUBLIC OR type STREQUAL STATIC_LIBRARY)
    set_property(GLOBAL APPEND PROPERTY ESPALIER_${name}_PACKAGES ${arg_PACKAGE})
    set_property(GLOBAL APPEND PROPERTY ESPALIER_${name}_PKG_CONFIG ${arg_PKG_CONFIG})
    set_property(GLOBAL APPEND PROPERTY ESPALIER_${name}_DEBIAN ${arg_DEBIAN})
  endif()
endfunction()
