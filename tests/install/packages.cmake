# cmake -DCPACK=<program> -DDPKG_DEB=<program> -DBUILD=<folder> -DFOLDER=<to write> -DLIBDIR=<below usr> -DCOMPILER=<C++>
#       -DSOURCE=<file> -DSCENE=<file> -P packages.cmake
# Debian's packages, made of this build and unpacked side by side: a program is built with what the development package holds and
# run with what the library's package holds, and the command's package runs a scene.
file(REMOVE_RECURSE ${FOLDER})
file(MAKE_DIRECTORY ${FOLDER}/root)
execute_process(COMMAND ${CPACK} -G DEB -B ${FOLDER} WORKING_DIRECTORY ${BUILD} COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
file(GLOB packages ${FOLDER}/*.deb)
set(expected ${packages})
list(FILTER expected EXCLUDE REGEX "/dvdx-mpi_[^/]*$") # where MPI was found, what the command needs to run on many ranks
list(LENGTH expected count)
if(NOT count EQUAL 3)
  message(FATAL_ERROR "three packages should be made, not: ${packages}")
endif()
foreach(package ${packages})
  execute_process(COMMAND ${DPKG_DEB} -f ${package} Depends COMMAND_ERROR_IS_FATAL ANY OUTPUT_VARIABLE depends)
  message(STATUS "${package} depends on ${depends}")
  if(package MATCHES "libdvdx-dev" AND NOT depends MATCHES "libdvdx[0-9]+ \\(= ")
    message(FATAL_ERROR "the development package must ask for its own library")
  endif()
  execute_process(COMMAND ${DPKG_DEB} -x ${package} ${FOLDER}/root COMMAND_ERROR_IS_FATAL ANY)
endforeach()

set(usr ${FOLDER}/root/usr)
execute_process(COMMAND ${COMPILER} -std=c++20 -I${usr}/include ${SOURCE} -o ${FOLDER}/program -L${usr}/${LIBDIR} -ldvdx
                COMMAND_ERROR_IS_FATAL ANY)
foreach(program "${FOLDER}/program" "${usr}/bin/dvdx;run;${SCENE}")
  execute_process(COMMAND ${CMAKE_COMMAND} -E env LD_LIBRARY_PATH=${usr}/${LIBDIR} ${program} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
