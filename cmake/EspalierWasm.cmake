# SPDX-License-Identifier: Apache-2.0
# What a build for WebAssembly needs of other libraries. Debian has no packages of them for WebAssembly, so
# pugixml and zlib are compiled from the sources that scripts/wasm-sources fetches.
set(ESPALIER_WASM_SOURCES ${PROJECT_SOURCE_DIR}/build/wasm-sources CACHE PATH
    "Folder with the sources pugixml/ and zlib/")
foreach(file pugixml/src/pugixml.cpp zlib/inflate.c)
  if(NOT EXISTS ${ESPALIER_WASM_SOURCES}/${file})
    message(FATAL_ERROR "${ESPALIER_WASM_SOURCES}/${file} is missing: run scripts/wasm-sources first")
  endif()
endforeach()
enable_language(C)

add_library(pugixml STATIC EXCLUDE_FROM_ALL ${ESPALIER_WASM_SOURCES}/pugixml/src/pugixml.cpp)
target_include_directories(pugixml SYSTEM PUBLIC ${ESPALIER_WASM_SOURCES}/pugixml/src)
add_library(pugixml::pugixml ALIAS pugixml)

set(zlib_names adler32 compress crc32 deflate inffast inflate inftrees trees uncompr zutil)
set(zlib_sources)
foreach(name IN LISTS zlib_names)
  list(APPEND zlib_sources ${ESPALIER_WASM_SOURCES}/zlib/${name}.c)
endforeach()
add_library(zlib STATIC EXCLUDE_FROM_ALL ${zlib_sources})
set_target_properties(zlib PROPERTIES UNITY_BUILD OFF)
target_include_directories(zlib SYSTEM PUBLIC ${ESPALIER_WASM_SOURCES}/zlib)
target_compile_options(zlib PRIVATE -w)
add_library(ZLIB::ZLIB ALIAS zlib)

# Headers alone, which serve every machine. Links to the folders keep the headers of Debian's C library, beside
# them in /usr/include, out of sight.
set(Eigen3_DIR /usr/share/eigen3/cmake CACHE PATH "Eigen's package")
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
target_compile_options(Eigen3::Eigen INTERFACE
                       -msse2 "SHELL:-include ${CMAKE_CURRENT_LIST_DIR}/wasm-eigen.h")
set(ESPALIER_HEADER_LINKS ${PROJECT_BINARY_DIR}/header-links)
foreach(folder fast_float fmt nlohmann)
  if(NOT EXISTS /usr/include/${folder})
    message(FATAL_ERROR "/usr/include/${folder} is missing: run scripts/install-packages web first")
  endif()
  file(MAKE_DIRECTORY ${ESPALIER_HEADER_LINKS})
  file(CREATE_LINK /usr/include/${folder} ${ESPALIER_HEADER_LINKS}/${folder} SYMBOLIC)
endforeach()
add_library(nlohmann_json INTERFACE)
target_include_directories(nlohmann_json SYSTEM INTERFACE ${ESPALIER_HEADER_LINKS})
add_library(nlohmann_json::nlohmann_json ALIAS nlohmann_json)
