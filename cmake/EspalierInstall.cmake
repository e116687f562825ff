# SPDX-License-Identifier: Apache-2.0
# Defines what `cmake --install` installs, for find_package(espalier) and for pkg-config. Each component has
# its own export set and .pc file, so that it requires nothing that only another component needs.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/espalier)
set(pkg_config_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
get_property(components GLOBAL PROPERTY ESPALIER_COMPONENTS)

# A relative path, so that the installed tree can be moved.
file(RELATIVE_PATH prefix_from_here /prefix/${pkg_config_dir} /prefix)

set(ESPALIER_OPTIONAL_COMPONENTS compare petsc cuda cgns)
set(component_facts)
foreach(name IN LISTS components)
  get_property(depends GLOBAL PROPERTY ESPALIER_${name}_DEPENDS)
  get_property(packages GLOBAL PROPERTY ESPALIER_${name}_PACKAGES)
  string(APPEND component_facts "set(_espalier_${name}_depends ${depends})\n"
                                "set(_espalier_${name}_packages ${packages})\n")

  # Optional shared libraries, which need software that most users lack, get packages of their own.
  set(component libraries)
  if(name IN_LIST ESPALIER_OPTIONAL_COMPONENTS)
    set(component ${name})
  endif()
  install(TARGETS espalier_${name} EXPORT espalier-${name}
          LIBRARY COMPONENT ${component} NAMELINK_COMPONENT development
          ARCHIVE COMPONENT development
          PUBLIC_HEADER COMPONENT development)
  get_target_property(source_dir espalier_${name} SOURCE_DIR)
  get_property(folder GLOBAL PROPERTY ESPALIER_${name}_FOLDER)
  get_property(headers GLOBAL PROPERTY ESPALIER_${name}_HEADERS)
  foreach(header IN LISTS headers)
    cmake_path(GET header PARENT_PATH inner)
    install(FILES ${source_dir}/${header} COMPONENT development
            DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/espalier/${folder}/${inner})
  endforeach()
  install(EXPORT espalier-${name} NAMESPACE espalier:: DESTINATION ${package_dir}
          FILE espalier-${name}.cmake COMPONENT development)

  get_target_property(library_name espalier_${name} OUTPUT_NAME)
  if(NOT library_name)
    set(library_name espalier_${name})
  endif()
  get_property(pkg_config_names GLOBAL PROPERTY ESPALIER_${name}_PKG_CONFIG)
  set(other_libraries ${pkg_config_names})
  list(FILTER other_libraries INCLUDE REGEX "^-[lL]")
  list(FILTER pkg_config_names EXCLUDE REGEX "^-[lL]")
  list(TRANSFORM depends PREPEND espalier- OUTPUT_VARIABLE requires)
  list(APPEND requires ${pkg_config_names})
  list(JOIN requires " " requires)
  list(JOIN other_libraries " " other_libraries)
  configure_file(cmake/espalier.pc.in ${PROJECT_BINARY_DIR}/pkgconfig/espalier-${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/pkgconfig/espalier-${name}.pc
          DESTINATION ${pkg_config_dir} COMPONENT development)
endforeach()

configure_package_config_file(cmake/espalier-config.cmake.in espalier-config.cmake
                              INSTALL_DESTINATION ${package_dir} NO_SET_AND_CHECK_MACRO)
# The same rule as for ESPALIER_SOVERSION.
if(PROJECT_VERSION_MAJOR EQUAL 0)
  set(compatibility SameMinorVersion)
else()
  set(compatibility SameMajorVersion)
endif()
write_basic_package_version_file(espalier-config-version.cmake COMPATIBILITY ${compatibility})
install(FILES ${PROJECT_BINARY_DIR}/espalier-config.cmake
              ${PROJECT_BINARY_DIR}/espalier-config-version.cmake
              cmake/FindCgns.cmake cmake/FindOpenSubdivCpu.cmake cmake/FindPetscReal.cmake
        DESTINATION ${package_dir} COMPONENT development)
