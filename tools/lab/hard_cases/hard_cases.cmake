# The hard cases that `dvdx stability` runs and prints, as a library that the tests share.
file(GLOB DVDX_HARD_CASES_FILES CONFIGURE_DEPENDS lab/hard_cases/*.cpp)
add_library(dvdx_stability STATIC ${DVDX_HARD_CASES_FILES})
target_link_libraries(dvdx_stability PUBLIC dvdx_report dvdx_heat PRIVATE dvdx_tool_options fmt::fmt Threads::Threads)
set_source_files_properties(lab/hard_cases/plain_springs.cpp PROPERTIES COMPILE_OPTIONS "${DVDX_PLAIN_LOOP_OPTIONS}")
