# What `dvdx stability` runs and shows, as a library that the tests share.
find_package(Threads REQUIRED)
add_library(dvdx_stability STATIC
            dvdx/stability/cases.cpp dvdx/stability/contact_cases.cpp dvdx/stability/input_cases.cpp
            dvdx/stability/linear_cases.cpp dvdx/stability/long_runs.cpp dvdx/stability/network_cases.cpp
            dvdx/stability/plain_springs.cpp dvdx/stability/show.cpp dvdx/stability/suite.cpp)
target_link_libraries(dvdx_stability PUBLIC dvdx_report PRIVATE dvdx_tool_options fmt::fmt Threads::Threads)
