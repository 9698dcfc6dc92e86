# Ensembles of sheets, as a library that the command, the hard cases and the tests share.
find_package(Threads REQUIRED)
file(GLOB DVDX_HEAT_FILES CONFIGURE_DEPENDS lab/heat/*.cpp)
add_library(dvdx_heat STATIC ${DVDX_HEAT_FILES})
target_link_libraries(dvdx_heat PUBLIC dvdx_scene PRIVATE dvdx_tool_options fmt::fmt Threads::Threads)
compiled_together(dvdx_heat)
