# cmake -DPKG_CONFIG=<program> -DPREFIX=<installed> -DLIBDIR=<below it> -DCOMPILER=<C++> -DSOURCE=<file> -DPROGRAM=<to write>
#       -P pkg_config.cmake
# A program compiled by what pkg-config says and nothing else runs, with the shared library and with the archive, which lie in
# one folder; and each has the form that was asked for.
set(ENV{PKG_CONFIG_PATH} ${PREFIX}/${LIBDIR}/pkgconfig)
find_program(READELF readelf REQUIRED)
foreach(package dvdx dvdx-static)
  execute_process(COMMAND ${PKG_CONFIG} --cflags --libs ${package} OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE
                  COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(flags UNIX_COMMAND "${flags}")
  execute_process(COMMAND ${COMPILER} -std=c++20 ${SOURCE} -o ${PROGRAM} ${flags} COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND ${READELF} --dynamic ${PROGRAM} OUTPUT_VARIABLE needed COMMAND_ERROR_IS_FATAL ANY)
  string(FIND "${needed}" "libdvdx" at)
  if(package STREQUAL "dvdx")
    set(ENV{LD_LIBRARY_PATH} ${PREFIX}/${LIBDIR})
    if(at EQUAL -1)
      message(FATAL_ERROR "${package}: the program does not need the shared library")
    endif()
  else()
    set(ENV{LD_LIBRARY_PATH} "")
    if(NOT at EQUAL -1)
      message(FATAL_ERROR "${package}: the program needs the shared library")
    endif()
  endif()
  execute_process(COMMAND ${PROGRAM} OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
endforeach()
