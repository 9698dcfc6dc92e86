# cmake -DBUILD=<build folder> -DPREFIX=<folder> -P install_files.cmake
file(REMOVE_RECURSE ${PREFIX})
foreach(component library development)
  execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --component ${component} --prefix ${PREFIX} OUTPUT_QUIET
                  COMMAND_ERROR_IS_FATAL ANY)
endforeach()

# No public header may bring in what a consumer need not have.
file(GLOB_RECURSE headers ${PREFIX}/include/*.h ${PREFIX}/include/*.hpp)
if(NOT headers)
  message(FATAL_ERROR "no header was installed")
endif()
foreach(header IN LISTS headers)
  file(STRINGS ${header} includes REGEX "^ *# *include")
  if(includes MATCHES "xsimd|Eigen|omp\\.h|fmt/|nlohmann|CLI|/src/|inl\\.hpp")
    message(FATAL_ERROR "${header} includes what is not public:\n${includes}")
  endif()
endforeach()
