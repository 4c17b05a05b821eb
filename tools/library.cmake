# Everything the subcommands share: metrics, baselines, reports, progress. Commands and main belong to the program.
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
file(GLOB AIRSIDE_TOOLS_SOURCES CONFIGURE_DEPENDS
  ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/baselines/*.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/report/*.cpp)
list(FILTER AIRSIDE_TOOLS_SOURCES EXCLUDE REGEX "/tools/(main|command_[^/]*)\\.cpp$")

add_library(airside_tools STATIC ${AIRSIDE_TOOLS_SOURCES})
target_include_directories(airside_tools PUBLIC ${PROJECT_SOURCE_DIR})
target_link_libraries(airside_tools PUBLIC airside_sim nlohmann_json::nlohmann_json fmt::fmt)
