# cmake -DPKG_CONFIG=<program> -DPREFIX=<installed> -DLIBDIR=<below it> -DCOMPILER=<C++> -DSOURCE=<file> -DPROGRAM=<to write>
#       -P pkg_config.cmake
# A program compiled by what pkg-config says and nothing else runs, with the shared library and with the archive.
set(ENV{PKG_CONFIG_PATH} ${PREFIX}/${LIBDIR}/pkgconfig)
set(ENV{LD_LIBRARY_PATH} ${PREFIX}/${LIBDIR})
foreach(form shared static)
  set(ask --cflags --libs)
  if(form STREQUAL "static")
    list(PREPEND ask --static)
  endif()
  execute_process(COMMAND ${PKG_CONFIG} ${ask} dvdx OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  if(form STREQUAL "static")
    string(REPLACE "-ldvdx" "-l:libdvdx.a" flags "${flags}")
  endif()
  separate_arguments(flags UNIX_COMMAND "${flags}")
  execute_process(COMMAND ${COMPILER} -std=c++20 ${SOURCE} -o ${PROGRAM} ${flags} COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND ${PROGRAM} OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
endforeach()
