# SPDX-License-Identifier: Apache-2.0

# espalier_library(NAME SOURCES ... HEADERS ... DEPENDS ...)
#
# One library a folder: espalier_NAME, with the alias espalier::NAME. Its headers are included as
# <espalier/NAME/header.h>, by a link of its own to the folder, so that no target sees the headers of
# one that it does not depend on.
function(espalier_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;HEADERS;DEPENDS")
  set(target espalier_${name})
  add_library(${target} ${arg_SOURCES} ${arg_HEADERS})
  add_library(espalier::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)

  set(include_dir ${PROJECT_BINARY_DIR}/include/${name})
  file(MAKE_DIRECTORY ${include_dir}/espalier)
  file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR} ${include_dir}/espalier/${name} SYMBOLIC)
  target_include_directories(${target} PUBLIC ${include_dir})
  foreach(dependency IN LISTS arg_DEPENDS)
    target_link_libraries(${target} PUBLIC espalier::${dependency})
  endforeach()
  espalier_compile_options(${target})
endfunction()

# What every target of ours is compiled with; none of it reaches those who link us, but C++20.
function(espalier_compile_options target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wconversion -Wshadow
                         $<$<BOOL:${ESPALIER_WARNINGS_AS_ERRORS}>:-Werror>)
endfunction()
