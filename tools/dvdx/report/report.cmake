# What `dvdx report` measures and shows, as a library that the tests share. The plain loops that it is measured against are
# compiled for the instruction sets that the library has.
file(READ ${CMAKE_CURRENT_SOURCE_DIR}/report.html.in DVDX_REPORT_PAGE)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS report.html.in)
string(TOUPPER "${CMAKE_BUILD_TYPE}" DVDX_BUILD_TYPE)
string(STRIP "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${DVDX_BUILD_TYPE}} -ffp-contract=off" DVDX_COMPILER_FLAGS)
configure_file(dvdx/report/build_facts.cpp.in report_build_facts.cpp @ONLY)

set(DVDX_PLAIN_LOOPS dvdx/report/plain_loops_default.cpp dvdx/report/plain_loops_other.cpp)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set(DVDX_PLAIN_LOOPS dvdx/report/plain_loops_default.cpp dvdx/report/plain_loops_x86.cpp dvdx/report/plain_loops_avx2.cpp
                       dvdx/report/plain_loops_avx512.cpp)
  set_source_files_properties(dvdx/report/plain_loops_avx2.cpp PROPERTIES COMPILE_OPTIONS "-mavx2")
  set_source_files_properties(dvdx/report/plain_loops_avx512.cpp PROPERTIES
                              COMPILE_OPTIONS "-mavx512f;-mavx512bw;-mavx512cd;-mavx512dq;-mavx512vl;-mprefer-vector-width=512")
endif()

add_library(dvdx_report STATIC
            dvdx/closed_form.cpp dvdx/report/baseline.cpp dvdx/report/build.cpp dvdx/report/claims.cpp dvdx/report/compare.cpp
            dvdx/report/curves.cpp dvdx/report/grid.cpp dvdx/report/interactive.cpp dvdx/report/json.cpp dvdx/report/long_run.cpp dvdx/report/machine.cpp
            dvdx/report/measure.cpp dvdx/report/network_runs.cpp dvdx/report/orders.cpp dvdx/report/page.cpp dvdx/report/pictures.cpp
            dvdx/report/reference.cpp dvdx/report/sample.cpp dvdx/report/summary.cpp dvdx/report/table.cpp dvdx/report/throughput.cpp dvdx/report/trace.cpp ${DVDX_PLAIN_LOOPS}
            ${CMAKE_CURRENT_BINARY_DIR}/report_build_facts.cpp)
target_link_libraries(dvdx_report PUBLIC dvdx_scene CLI11::CLI11 PRIVATE dvdx_tool_options fmt::fmt)
compiled_together(dvdx_report)
# g++ wants what a lambda of a template holds to be declared in the file that is compiled.
set_source_files_properties(dvdx/report/baseline.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
