# What `dvdx tune` measures, chooses and shows, as a library that the tests share.
add_library(dvdx_tune STATIC
            dvdx/scene_options.cpp dvdx/tune/advice.cpp dvdx/tune/bench.cpp dvdx/tune/candidates.cpp dvdx/tune/json.cpp
            dvdx/tune/search.cpp dvdx/tune/table.cpp dvdx/tune/tune_scene.cpp dvdx/tune/words.cpp)
target_link_libraries(dvdx_tune PUBLIC dvdx_report PRIVATE dvdx_tool_options fmt::fmt)
compiled_together(dvdx_tune)
