# cmake -DNM=<nm> -DARCHIVE=<libdvdx.a> -P check_math_library.cmake
#
# No object of the library calls a function of the math library whose last bit differs from one such library to the next: states,
# coefficients, numbers of sub-steps and `explain` are then the same everywhere. Functions that IEEE 754 defines to the bit may
# be called (sqrt, fma, remainder, nearbyint, floor, frexp, ldexp, nextafter). Nor does one print or read numbers by the caller's
# locale: kernel/src/scene/text.hpp writes them by std::to_chars.
set(inexact "sin|cos|tan|sincos|asin|acos|atan|atan2|sinh|cosh|tanh|asinh|acosh|atanh|sinpi|cospi|exp|exp2|exp10|expm1|log|log2|log10|log1p|pow|hypot|cbrt|erf|erfc|tgamma|lgamma")
set(of_locale "f?printf|sn?printf|vsn?printf|v?f?printf|f?scanf|sscanf|strto(d|f|ld|l|ul|ll|ull)|ato(f|i|l|ll)|setlocale|localeconv")
execute_process(COMMAND ${NM} -A --undefined-only ${ARCHIVE} OUTPUT_VARIABLE symbols RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "${NM} cannot read ${ARCHIVE}")
endif()
string(REPLACE ";" "," symbols "${symbols}")
string(REPLACE "\n" ";" symbols "${symbols}")
set(faults "")
set(of_locale_faults "")
set(seen 0)
foreach(symbol IN LISTS symbols)
  # c++ std::sin(float) and the like are inline calls of these; g++ 12 and older libraries know __sin_finite.
  if(symbol MATCHES " U _?_?(${inexact})[fl]?(_finite)?(@.*)?$")
    string(APPEND faults "  ${symbol}\n")
  endif()
  if(symbol MATCHES " U _?_?(${of_locale})(_chk)?(@.*)?$")
    string(APPEND of_locale_faults "  ${symbol}\n")
  endif()
  if(symbol MATCHES " U memcpy")
    set(seen 1)
  endif()
endforeach()
if(NOT seen)
  message(FATAL_ERROR "${NM} shows not even memcpy among what ${ARCHIVE} calls: nothing was checked")
endif()
if(faults)
  message(FATAL_ERROR "the library calls functions whose bits depend on the math library:\n${faults}")
endif()
if(of_locale_faults)
  message(FATAL_ERROR "the library calls functions that follow the locale:\n${of_locale_faults}")
endif()
