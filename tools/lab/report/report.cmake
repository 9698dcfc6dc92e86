# The measurements and pages of `dvdx report`, as a library that the tests share. The plain loops of the baselines are compiled
# for the library's instruction sets.
string(TOUPPER "${CMAKE_BUILD_TYPE}" DVDX_BUILD_TYPE)
string(STRIP "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${DVDX_BUILD_TYPE}} -ffp-contract=off" DVDX_COMPILER_FLAGS)
configure_file(lab/report/build_facts.cpp.in report_build_facts.cpp @ONLY)

set(DVDX_PLAIN_LOOPS lab/plain/plain_loops_default.cpp lab/plain/plain_loops_other.cpp)
set_source_files_properties(lab/plain/plain_loops_default.cpp lab/plain/plain_loops_other.cpp lab/plain/plain_loops_x86.cpp lab/report/baseline.cpp
                            PROPERTIES COMPILE_OPTIONS "${DVDX_PLAIN_LOOP_OPTIONS}")
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set(DVDX_PLAIN_LOOPS lab/plain/plain_loops_default.cpp lab/plain/plain_loops_x86.cpp lab/plain/plain_loops_avx2.cpp
                       lab/plain/plain_loops_avx512.cpp)
  set_source_files_properties(lab/plain/plain_loops_avx2.cpp PROPERTIES COMPILE_OPTIONS "${DVDX_PLAIN_LOOP_OPTIONS};-mavx2")
  set_source_files_properties(lab/plain/plain_loops_avx512.cpp PROPERTIES
                              COMPILE_OPTIONS "${DVDX_PLAIN_LOOP_OPTIONS};-mavx512f;-mavx512bw;-mavx512cd;-mavx512dq;-mavx512vl;-mprefer-vector-width=512")
endif()

file(GLOB DVDX_REPORT_FILES CONFIGURE_DEPENDS lab/report/*.cpp)
add_library(dvdx_report STATIC ${DVDX_REPORT_FILES} ${DVDX_PLAIN_LOOPS} ${CMAKE_CURRENT_BINARY_DIR}/report_build_facts.cpp)
target_link_libraries(dvdx_report PUBLIC dvdx_closed_form PRIVATE dvdx_tool_options fmt::fmt)
compiled_together(dvdx_report)
# g++ requires the members of a lambda in a template to be declared in the compiled file itself.
set_source_files_properties(lab/report/baseline.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
