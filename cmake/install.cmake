# Installs the command with its manual and completions, the shared library, the headers, the static library, and the
# files of pkg-config and of CMake's find_package(cvol). `cpack` makes Debian packages of these.

# The libraries that a user of libcvol.a must link too, as a name, or as a path if linkers do not search there
# (clang's OpenMP): the library's own dependencies and theirs.
function(cvol_link_names out)
  set(names)
  foreach(item IN LISTS ARGN)
    string(REGEX REPLACE "^\\$<BUILD_INTERFACE:(.*)>$" "\\1" item "${item}")
    if(item STREQUAL "cvol_flags" OR item MATCHES "^\\$<|::@")
      continue()
    elseif(TARGET ${item})
      get_target_property(type ${item} TYPE)
      if(NOT type STREQUAL "INTERFACE_LIBRARY")
        foreach(property IMPORTED_LOCATION IMPORTED_LOCATION_RELEASE IMPORTED_LOCATION_NONE)
          get_target_property(file ${item} ${property})
          if(file)
            list(APPEND names ${file})
            break()
          endif()
        endforeach()
      endif()
      get_target_property(more ${item} INTERFACE_LINK_LIBRARIES)
      if(more)
        cvol_link_names(more ${more})
        list(APPEND names ${more})
      endif()
    else()
      list(APPEND names ${item})
    endif()
  endforeach()
  set(found)
  foreach(name IN LISTS names)
    get_filename_component(folder "${name}" DIRECTORY)
    if(NOT folder MATCHES "llvm")
      get_filename_component(name "${name}" NAME)
      string(REGEX REPLACE "^(-l|lib)|\\.(so|a)[.0-9]*$" "" name "${name}")
    endif()
    list(APPEND found ${name})
  endforeach()
  if(found)
    list(REMOVE_DUPLICATES found)
  endif()
  set(${out} ${found} PARENT_SCOPE)
endfunction()

get_target_property(needs cvol_library LINK_LIBRARIES)
cvol_link_names(names ${needs})
set(flags ${names})
list(TRANSFORM flags PREPEND "-l" REGEX "^[^/]")
string(REPLACE ";" " " CVOL_STATIC_LIBS "${flags}")

include(CMakePackageConfigHelpers)
set(CVOL_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/cvol)
file(RELATIVE_PATH CVOL_UP /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" CVOL_UP "${CVOL_UP}")
configure_file(cmake/cvol.pc.in ${PROJECT_BINARY_DIR}/cvol.pc @ONLY)
configure_package_config_file(cmake/cvolConfig.cmake.in ${PROJECT_BINARY_DIR}/cvolConfig.cmake
  INSTALL_DESTINATION ${CVOL_CMAKE_DIR} PATH_VARS CMAKE_INSTALL_INCLUDEDIR CMAKE_INSTALL_LIBDIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/cvolConfigVersion.cmake COMPATIBILITY SameMinorVersion)

install(TARGETS cvol_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT command)
# The pages of cvol export, if make web built them.
install(FILES ${PROJECT_SOURCE_DIR}/build-web/site/index.html ${PROJECT_SOURCE_DIR}/build-web/site/convert.js OPTIONAL
  COMPONENT command DESTINATION ${CMAKE_INSTALL_DATADIR}/cvol/web/site)
install(FILES ${PROJECT_SOURCE_DIR}/build-web/viewer.html OPTIONAL COMPONENT command
  DESTINATION ${CMAKE_INSTALL_DATADIR}/cvol/web)
install(TARGETS cvol_library ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
if(TARGET cvol_shared)
  install(TARGETS cvol_shared LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library
    NAMELINK_COMPONENT development)
endif()
install(DIRECTORY include/cvol DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
install(FILES ${PROJECT_BINARY_DIR}/cvol.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
install(FILES ${PROJECT_BINARY_DIR}/cvolConfig.cmake ${PROJECT_BINARY_DIR}/cvolConfigVersion.cmake
  DESTINATION ${CVOL_CMAKE_DIR} COMPONENT development)

# Manual pages and completions, from the output of --help.
if(NOT CVOL_SANITIZE AND NOT CMAKE_CROSSCOMPILING)
  set(manual ${PROJECT_BINARY_DIR}/manual)
  set(scripts ${PROJECT_SOURCE_DIR}/scripts/help_to_man.sh ${PROJECT_SOURCE_DIR}/scripts/help_to_completion.sh)
  add_custom_command(OUTPUT ${manual}/man/cvol.1 ${manual}/completion/cvol.bash
    COMMAND sh ${PROJECT_SOURCE_DIR}/scripts/help_to_man.sh $<TARGET_FILE:cvol_command> ${manual}/man
    COMMAND sh ${PROJECT_SOURCE_DIR}/scripts/help_to_completion.sh $<TARGET_FILE:cvol_command> ${manual}/completion
    DEPENDS cvol_command ${scripts}
    COMMENT "Manual pages and completions"
    VERBATIM)
  add_custom_target(cvol_manual ALL DEPENDS ${manual}/man/cvol.1 ${manual}/completion/cvol.bash)
  install(DIRECTORY ${manual}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT command)
  install(FILES ${manual}/completion/cvol.bash RENAME cvol COMPONENT command
    DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
  install(FILES ${manual}/completion/_cvol COMPONENT command
    DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)
  install(FILES ${manual}/completion/cvol.fish COMPONENT command
    DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
endif()

# The licences of what every libcvol contains (LICENSE-NOTES.md).
foreach(part inter stb)
  install(FILES third_party/${part}/LICENSE RENAME LICENSE-${part} COMPONENT library
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/cvol)
endforeach()

# Debian packages: cvol, libcvol0, libcvol-dev, and python3-cvol if its files are there.
set(CPACK_DEBIAN_COMMAND_PACKAGE_NAME cvol)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libcvol${PROJECT_VERSION_MAJOR})
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libcvol-dev)
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-cvol)
foreach(component command library development python)
  string(TOUPPER ${component} upper)
  install(FILES LICENSE RENAME copyright COMPONENT ${component} EXCLUDE_FROM_ALL
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
endforeach()
install(DIRECTORY python/cvol DESTINATION lib/python3/dist-packages COMPONENT python EXCLUDE_FROM_ALL
  PATTERN __pycache__ EXCLUDE PATTERN "*.so*" EXCLUDE)
# By these files numcodecs and xarray find the package.
file(WRITE ${PROJECT_BINARY_DIR}/METADATA
  "Metadata-Version: 2.1\nName: cvol\nVersion: ${PROJECT_VERSION}\n")
install(FILES ${PROJECT_BINARY_DIR}/METADATA python/entry_points.txt COMPONENT python EXCLUDE_FROM_ALL
  DESTINATION lib/python3/dist-packages/cvol-${PROJECT_VERSION}.dist-info)
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_CONTACT "cvol maintainers <cvol@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "volume data that stays compressed")
set(CPACK_COMPONENTS_ALL command library development python)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
# (Modules, which the command loads too, are in the library's package.)
set(CPACK_DEBIAN_COMMAND_PACKAGE_DEPENDS "libcvol${PROJECT_VERSION_MAJOR} (= ${PROJECT_VERSION})")
set(CPACK_COMPONENT_COMMAND_DESCRIPTION "Compresses volumes, and renders and computes with what is compressed.")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/cmake/triggers)
set(CPACK_COMPONENT_LIBRARY_DESCRIPTION "The shared library.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libcvol${PROJECT_VERSION_MAJOR} (= ${PROJECT_VERSION})")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "Headers and the static library.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
  "python3 (>= 3.9), python3-numpy, libcvol${PROJECT_VERSION_MAJOR} (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-xarray, python3-dask, python3-zarr")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "The Python package.")
include(CPack)
