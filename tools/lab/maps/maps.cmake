# The stability maps as a library that the command and the tests share. Eigen's matrix exponential belongs to its unsupported
# modules, which Debian's package contains.
find_package(Eigen3 REQUIRED)
get_target_property(DVDX_EIGEN_INCLUDE Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
file(GLOB DVDX_MAPS_FILES CONFIGURE_DEPENDS lab/maps/*.cpp)
add_library(dvdx_maps STATIC ${DVDX_MAPS_FILES})
target_include_directories(dvdx_maps SYSTEM PUBLIC ${DVDX_EIGEN_INCLUDE})
target_link_libraries(dvdx_maps PUBLIC dvdx_scene PRIVATE dvdx_tool_options fmt::fmt)
compiled_together(dvdx_maps)
set_source_files_properties(lab/maps/measurement.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
