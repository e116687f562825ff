# SPDX-License-Identifier: Apache-2.0
# Defines the target `docs`: HTML pages of the installed headers, in docs/html of the build folder. Any
# warning of Doxygen is an error. Include this after all folders.
include_guard(GLOBAL)
find_package(Doxygen 1.9.4 REQUIRED)

set(ESPALIER_DOCS_INPUT "\"${PROJECT_SOURCE_DIR}/docs/namespaces.dox\"")
set(ESPALIER_DOCS_FOLDERS)
get_property(components GLOBAL PROPERTY ESPALIER_COMPONENTS)
foreach(component IN LISTS components)
  get_property(headers GLOBAL PROPERTY ESPALIER_${component}_HEADERS)
  get_property(folder GLOBAL PROPERTY ESPALIER_${component}_FOLDER)
  set(include_dir ${PROJECT_BINARY_DIR}/include/${component})
  if(folder)
    list(TRANSFORM headers PREPEND ${include_dir}/espalier/${folder}/)
  else()  # The headers of the C library are in its folder itself.
    get_target_property(headers espalier_${component} PUBLIC_HEADER)
    get_target_property(include_dir espalier_${component} SOURCE_DIR)
  endif()
  list(SORT headers)
  foreach(header IN LISTS headers)
    string(APPEND ESPALIER_DOCS_INPUT " \\\n  \"${header}\"")
  endforeach()
  string(APPEND ESPALIER_DOCS_FOLDERS " \"${include_dir}\"")
endforeach()
set(ESPALIER_DOCS_OUTPUT ${PROJECT_BINARY_DIR}/docs)
configure_file(${PROJECT_SOURCE_DIR}/docs/Doxyfile.in ${ESPALIER_DOCS_OUTPUT}/Doxyfile @ONLY)

add_custom_target(docs COMMAND Doxygen::doxygen ${ESPALIER_DOCS_OUTPUT}/Doxyfile
                  COMMENT "Pages of the public headers: docs/html" VERBATIM)
