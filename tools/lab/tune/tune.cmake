# The measurements, choices and tables of `dvdx tune`, as a library that the tests share.
file(GLOB DVDX_TUNE_FILES CONFIGURE_DEPENDS lab/tune/*.cpp)
add_library(dvdx_tune STATIC ${DVDX_TUNE_FILES})
target_link_libraries(dvdx_tune PUBLIC dvdx_report PRIVATE dvdx_tool_options fmt::fmt)
compiled_together(dvdx_tune)
