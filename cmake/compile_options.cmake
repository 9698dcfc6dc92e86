# The compile options of every target of ours. Nothing here reaches a consumer: usage requirements carry only include
# directories and the language level.
add_library(dvdx_options INTERFACE)
target_compile_features(dvdx_options INTERFACE cxx_std_20)
# No compiler may fuse a multiply and an add on its own: every ISA must give the same bits.
target_compile_options(dvdx_options INTERFACE -ffp-contract=off -fno-math-errno -fvisibility=hidden)
# A switch over an enumeration names every value: a new shape of a contact, kind of a source or form is not left out anywhere.
target_compile_options(dvdx_options INTERFACE -Werror=switch)
# Where several files are compiled at once, g++ looks for memory that it no longer needs so often that it takes a tenth of the time.
set(DVDX_UNITY_OPTIONS)
if(DVDX_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  cmake_host_system_information(RESULT DVDX_MEMORY QUERY TOTAL_PHYSICAL_MEMORY) # MiB
  cmake_host_system_information(RESULT DVDX_CORES QUERY NUMBER_OF_LOGICAL_CORES)
  math(EXPR DVDX_MEMORY "${DVDX_MEMORY} / ${DVDX_CORES}")
  if(DVDX_MEMORY GREATER 2000)
    set(DVDX_UNITY_OPTIONS --param=ggc-min-heapsize=700000) # KiB; compilers take 1.2 GiB at most
  endif()
endif()
if(DVDX_DEVELOPER)
  target_compile_options(dvdx_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion
                                                -Wold-style-cast -Wnon-virtual-dtor -Werror)
endif()
if(DVDX_SANITIZE)
  target_compile_options(dvdx_options INTERFACE -fsanitize=${DVDX_SANITIZE} -fno-omit-frame-pointer -g1
                                                -fno-sanitize-recover=all)
  target_link_options(dvdx_options INTERFACE -fsanitize=${DVDX_SANITIZE})
  if(DVDX_SANITIZE MATCHES "address") # which sees what a null pointer or one beyond an object reads, for a seventh less to compile
    target_compile_options(dvdx_options INTERFACE -fno-sanitize=null,object-size)
  endif()
  if(DVDX_SANITIZE STREQUAL "thread" AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU") # a report shows one frame, not all; a seventh of the time
    target_compile_options(dvdx_options INTERFACE "SHELL:--param tsan-instrument-func-entry-exit=0")
  endif()
  # With every temporary on the stack watched, g++ takes 206 s for the springs of one instruction set in place of 14. The passes
  # walk columns on the heap, which stay watched; clang++, which the fuzzers are compiled by, watches both.
  if(DVDX_SANITIZE MATCHES "address" AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(dvdx_options INTERFACE "SHELL:--param asan-stack=0" -fno-sanitize-address-use-after-scope)
  endif()
endif()
if(DVDX_FUZZ)  # who counts what inputs reach; the engine itself is linked by tests/fuzz
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    message(FATAL_ERROR "DVDX_FUZZ needs clang++, which brings libFuzzer: -DCMAKE_CXX_COMPILER=clang++")
  endif()
  target_compile_options(dvdx_options INTERFACE -fsanitize=fuzzer-no-link)
endif()
