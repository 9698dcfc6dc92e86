# The files that `cmake --install` puts in place. Components: library (the shared one), development (all that a consumer compiles
# and links with), tools (the command).
include(CMakePackageConfigHelpers)

set(DVDX_CMAKEDIR ${CMAKE_INSTALL_LIBDIR}/cmake/dvdx)
install(DIRECTORY layouts/include/dvdx kernel/include/dvdx ${CMAKE_CURRENT_BINARY_DIR}/kernel/include/dvdx
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp"
        PATTERN fields.hpp EXCLUDE) # for the library and its command

install(TARGETS dvdx_shared EXPORT dvdx-shared
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT development)
install(TARGETS dvdx EXPORT dvdx-static ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
if(TARGET dvdx_openmp)
  install(TARGETS dvdx_openmp EXPORT dvdx-openmp ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
  set(DVDX_EXPORT_OPENMP dvdx-openmp)
  install(TARGETS dvdx_openmp_shared LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT development)
endif()
if(TARGET dvdx_mpi)
  install(TARGETS dvdx_mpi EXPORT dvdx-mpi ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
  set(DVDX_EXPORT_MPI dvdx-mpi)
endif()
foreach(set dvdx-shared dvdx-static ${DVDX_EXPORT_OPENMP} ${DVDX_EXPORT_MPI})
  install(EXPORT ${set} NAMESPACE dvdx:: DESTINATION ${DVDX_CMAKEDIR} COMPONENT development)
endforeach()

# All that must be there for `cmake --install`; the command is installed where it was built.
add_custom_target(dvdx_installed)
add_dependencies(dvdx_installed dvdx dvdx_shared)
foreach(target dvdx_openmp dvdx_openmp_shared dvdx_mpi)
  if(TARGET ${target})
    add_dependencies(dvdx_installed ${target})
  endif()
endforeach()

# Reads the header beside it, so it belongs to who develops.
install(DIRECTORY tools/python/dvdx DESTINATION ${CMAKE_INSTALL_DATADIR}/dvdx/python COMPONENT development
        FILES_MATCHING PATTERN "*.py" PATTERN "py.typed")

set(DVDX_DEFAULT_FORM static)
if(BUILD_SHARED_LIBS)
  set(DVDX_DEFAULT_FORM shared)
endif()
configure_package_config_file(cmake/dvdx-config.cmake.in dvdx-config.cmake INSTALL_DESTINATION ${DVDX_CMAKEDIR}
                              NO_SET_AND_CHECK_MACRO)
# Below 1.0 any minor version may change what a consumer compiles against.
write_basic_package_version_file(dvdx-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/dvdx-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/dvdx-config-version.cmake
        DESTINATION ${DVDX_CMAKEDIR} COMPONENT development)

file(RELATIVE_PATH DVDX_PREFIX_FROM_PC /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
# -ldvdx finds the shared library first where both lie in one folder, with --static too: the archive has a file of its own.
configure_file(cmake/dvdx.pc.in dvdx.pc @ONLY)
configure_file(cmake/dvdx-static.pc.in dvdx-static.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/dvdx.pc ${CMAKE_CURRENT_BINARY_DIR}/dvdx-static.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
