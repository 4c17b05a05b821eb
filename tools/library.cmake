# Everything the subcommands share: metrics, baselines, reports, progress. Commands and main belong to the program.
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(Ceres REQUIRED)
find_package(CURL REQUIRED)
file(GLOB_RECURSE AIRSIDE_TOOLS_SOURCES CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
list(FILTER AIRSIDE_TOOLS_SOURCES EXCLUDE REGEX "/tools/(cli|chaos|bench|box|gap_bound|python)/")
# What several subcommands share, and tests ask for.
list(TRANSFORM AIRSIDE_CLI_SHARED PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/cli/ OUTPUT_VARIABLE cli_shared)
list(APPEND AIRSIDE_TOOLS_SOURCES ${cli_shared})

# The page of a report is built into the program: a report needs no installed file and no network.
set(page_parts ${CMAKE_CURRENT_BINARY_DIR}/page_parts.cpp)
set(page_dir ${CMAKE_CURRENT_SOURCE_DIR}/report)
set(page_files palette_css=${page_dir}/palette.css page_css=${page_dir}/page.css
    chart_parts_js=${page_dir}/chart_parts.js page_js=${page_dir}/page.js uplot_css=${page_dir}/vendor/uplot.min.css
    uplot_js=${page_dir}/vendor/uplot.iife.min.js uplot_licence=${page_dir}/vendor/LICENSE.uplot)
list(JOIN page_files "|" page_inputs)
list(TRANSFORM page_files REPLACE "^[^=]+=" "" OUTPUT_VARIABLE page_depends)
add_custom_command(
  OUTPUT ${page_parts}
  COMMAND ${CMAKE_COMMAND} -DOUTPUT=${page_parts} "-DINPUTS=${page_inputs}" -P ${page_dir}/embed.cmake
  DEPENDS ${page_depends} ${page_dir}/embed.cmake
  VERBATIM)

add_library(airside_tools STATIC ${AIRSIDE_TOOLS_SOURCES} ${page_parts})
target_include_directories(airside_tools PUBLIC ${PROJECT_SOURCE_DIR})
target_link_libraries(airside_tools PUBLIC airside_sim airside_commit nlohmann_json::nlohmann_json fmt::fmt PRIVATE Ceres::ceres CURL::libcurl)
target_precompile_headers(airside_tools REUSE_FROM airside_precompiled_host)
# Ceres brings glog's macros; they must not reach other files of a unity build.
set_source_files_properties(${CMAKE_CURRENT_SOURCE_DIR}/gap/inference/parameter_fit.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
