# The stability maps as a library that the command and the tests share. Eigen's matrix exponential is part of its unsupported
# half, which Debian's package has too.
find_package(Eigen3 REQUIRED)
get_target_property(DVDX_EIGEN_INCLUDE Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
add_library(dvdx_maps STATIC
            dvdx/stability/analysis.cpp dvdx/stability/bounce.cpp dvdx/stability/growth_map.cpp
            dvdx/stability/maps.cpp dvdx/stability/maps_pictures.cpp dvdx/stability/maps_show.cpp dvdx/stability/measurement.cpp)
target_include_directories(dvdx_maps SYSTEM PUBLIC ${DVDX_EIGEN_INCLUDE})
target_link_libraries(dvdx_maps PUBLIC dvdx_scene PRIVATE dvdx_tool_options fmt::fmt)
compiled_together(dvdx_maps)
set_source_files_properties(dvdx/stability/measurement.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
