# The library, its Python module, and what `cmake --install` and CPack make of them.

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# One shared library that shows nothing but its face (viewer/library/relume.h): what it is made of
# and what that needs stay inside.
add_library(relume_library SHARED ${CMAKE_SOURCE_DIR}/viewer/library/relume.cpp)
target_link_libraries(relume_library PRIVATE relume_viewer)
target_link_options(relume_library PRIVATE LINKER:--exclude-libs,ALL LINKER:--as-needed)
target_include_directories(relume_library INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_compile_features(relume_library INTERFACE cxx_std_17)
set_target_properties(relume_library PROPERTIES OUTPUT_NAME relume EXPORT_NAME relume
  VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
  CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)

install(TARGETS relume_library EXPORT relume-targets
  LIBRARY COMPONENT program NAMELINK_COMPONENT development)
add_dependencies(relume_library relume_decode)
install(TARGETS relume_decode RUNTIME DESTINATION libexec/relume COMPONENT program)
install(FILES ${CMAKE_SOURCE_DIR}/viewer/library/relume.h
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/relume COMPONENT development)

# find_package(relume) and pkg-config.
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/relume)
install(EXPORT relume-targets FILE relume-config.cmake NAMESPACE relume::
  DESTINATION ${package_dir} COMPONENT development)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/relume-config-version.cmake
  COMPATIBILITY SameMinorVersion)
file(RELATIVE_PATH prefix_from_pkgconfig /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" prefix_from_pkgconfig "${prefix_from_pkgconfig}")
configure_file(${CMAKE_SOURCE_DIR}/cmake/relume.pc.in ${CMAKE_BINARY_DIR}/relume.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/relume-config-version.cmake DESTINATION ${package_dir}
  COMPONENT development)
install(FILES ${CMAKE_BINARY_DIR}/relume.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
  COMPONENT development)

if(RELUME_PROGRAM)
  install(TARGETS relume RUNTIME COMPONENT program)

  # The manual and the shell's completion say what the program itself says.
  foreach(page manual completion)
    add_custom_command(OUTPUT ${CMAKE_BINARY_DIR}/relume.${page}
      COMMAND relume ${page} > ${CMAKE_BINARY_DIR}/relume.${page} DEPENDS relume VERBATIM)
  endforeach()
  add_custom_target(relume_pages ALL
    DEPENDS ${CMAKE_BINARY_DIR}/relume.manual ${CMAKE_BINARY_DIR}/relume.completion)
  install(FILES ${CMAKE_BINARY_DIR}/relume.manual RENAME relume.1
    DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
  install(FILES ${CMAKE_BINARY_DIR}/relume.completion RENAME relume
    DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT program)
endif()
install(FILES ${CMAKE_SOURCE_DIR}/LICENSE RENAME copyright
  DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/relume COMPONENT program)

if(RELUME_PYTHON)
  set(RELUME_PYTHON_DIR lib/python3/dist-packages CACHE STRING
    "Where Python looks for modules, below the prefix")
  pybind11_add_module(relume_python MODULE NO_EXTRAS ${CMAKE_SOURCE_DIR}/viewer/python/module.cpp)
  target_link_libraries(relume_python PRIVATE relume_library relume_options)
  file(RELATIVE_PATH library_from_module /${RELUME_PYTHON_DIR} /${CMAKE_INSTALL_LIBDIR})
  set_target_properties(relume_python PROPERTIES OUTPUT_NAME relume
    LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/python
    INSTALL_RPATH "$ORIGIN/${library_from_module}")
  install(TARGETS relume_python LIBRARY DESTINATION ${RELUME_PYTHON_DIR} COMPONENT python)
endif()

# ./dev package: relume, librelume-dev, python3-relume.
if(NOT RELUME_PROGRAM)
  return()
endif()
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME relume)
set(CPACK_PACKAGE_CONTACT "The Relume developers")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL program development)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_BINARY_DIR})
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME relume)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION graphics)
# Loaded when they are first needed.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "libosmesa6, fonts-dejavu-core")
# dpkg's trigger does what the scripts do that CPack writes for shared libraries, and leaves nothing
# behind when the package is removed. CPack writes none that it finds named here, there or not.
set(package_control ${CMAKE_BINARY_DIR}/package_control)
file(WRITE ${package_control}/triggers "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_CONTROL_EXTRA ${package_control}/triggers
  ${package_control}/postinst ${package_control}/postrm)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME librelume-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "relume (= ${PROJECT_VERSION})")
if(RELUME_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-relume)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "relume (= ${PROJECT_VERSION}), python3, python3-numpy")
endif()
include(CPack)
