# Headers that take seconds to read and that most host sources include, read once a build instead of once a source.
# A set fits only sources with its flags. Presets dev and tidy do without, so that a missing #include shows there.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13
   AND NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
  add_compile_options(-Wno-stringop-overflow -Wno-array-bounds)  # more of bug 105651, once string is precompiled
endif()
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)

# In the sanitizer build only what computes for long is optimised: lib, sim, and tests that ask for it.
set(AIRSIDE_OPTIMISED $<$<CONFIG:Debug>:-O1>)

# airside_precompiled(set header... ): makes a set of headers.
function(airside_precompiled set)
  file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${set}.cpp CONTENT "" @ONLY)
  add_library(${set} OBJECT ${CMAKE_CURRENT_BINARY_DIR}/${set}.cpp)
  target_link_libraries(${set} PRIVATE Eigen3::Eigen fmt::fmt nlohmann_json::nlohmann_json)
  target_precompile_headers(${set} PRIVATE
    <Eigen/Dense> <algorithm> <array> <chrono> <cmath> <filesystem> <fmt/format.h> <fstream> <functional> <map>
    <memory> <nlohmann/json.hpp> <optional> <random> <regex> <set> <span> <sstream> <string> <thread> <variant>
    <vector> ${ARGN})
endfunction()

airside_precompiled(airside_precompiled_host)
set(AIRSIDE_PRECOMPILED_SIM airside_precompiled_host)
if(CMAKE_BUILD_TYPE STREQUAL "Debug")
  set(AIRSIDE_PRECOMPILED_SIM airside_precompiled_sim)
  airside_precompiled(airside_precompiled_sim)
  target_compile_options(airside_precompiled_sim PRIVATE ${AIRSIDE_OPTIMISED})
endif()
