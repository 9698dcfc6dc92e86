# cmake -DNM=<nm> -DOBJECTS="<object>;<object>" -P check_symbols.cmake
#
# An object that was compiled for one instruction set may define no function that another object could define too: of two
# weak definitions of one inline function the linker keeps any, and where it keeps the one with AVX-512 instructions, a
# program stops on a machine without them, far away from our code. So the only functions that other objects can see are
# inline ones of xsimd that take a register of the object's own instruction set as a template argument (g++ leaves a few of
# them out of line): nobody without these registers calls them, and the objects that share them are compiled with the same
# flags. Everything else is in unnamed namespaces; std:: and Eigen:: must be inlined away.
#
# Data may be shared (tables of coefficients): it holds no instructions.
#
# Without optimisation nothing is inlined, std::array::operator[] neither: unoptimised builds are not checked, and are for
# the machine that they were built on.
set(own_register "(sse2|sse3|ssse3|sse4_1|sse4_2|avx|avx2|fma3<|avx512f|avx512cd|avx512dq|avx512bw|neon64|neon)")
set(faults "")
foreach(object IN LISTS OBJECTS)
  execute_process(COMMAND ${NM} --demangle --defined-only ${object} OUTPUT_VARIABLE symbols RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${NM} cannot read ${object}")
  endif()
  # Semicolons and brackets mean something to CMake's lists.
  string(REPLACE ";" "," symbols "${symbols}")
  string(REPLACE "[" "(" symbols "${symbols}")
  string(REPLACE "]" ")" symbols "${symbols}")
  string(REPLACE "\n" ";" symbols "${symbols}")
  foreach(symbol IN LISTS symbols)
    # Functions that other objects can see: T (global), W (weak), i (chosen at load time).
    if(NOT symbol MATCHES "^[0-9a-f]* *([TWi]) (.*)$")
      continue()
    endif()
    set(kind ${CMAKE_MATCH_1})
    set(name ${CMAKE_MATCH_2})
    if(name MATCHES "xsimd::" AND name MATCHES "xsimd::${own_register}" AND NOT name MATCHES "^(std|Eigen)::")
      continue()
    endif()
    string(APPEND faults "  ${object}: ${kind} ${name}\n")
  endforeach()
endforeach()
if(faults)
  message(FATAL_ERROR "objects of single instruction sets define what others may define too:\n${faults}")
endif()
