# Refuses a list AIRSIDE_TOPOLOGIES that this source cannot be built with. A build folder keeps the list of its first
# configuration: after an update it may name a type that is gone, or lack one that came in since.

file(STRINGS ${CMAKE_CURRENT_LIST_DIR}/airside/topology.hpp lines REGEX "^struct [A-Za-z0-9_]+ {$")
file(READ ${CMAKE_CURRENT_LIST_DIR}/airside/topology.hpp text)
set(known "")
foreach(line ${lines})
  string(REGEX REPLACE "^struct ([A-Za-z0-9_]+) {$" "\\1" tag "${line}")
  if(text MATCHES "struct ${tag} {\n  static constexpr int vavs")
    list(APPEND known ${tag})
  endif()
endforeach()

# airside_refuse_topologies(found expected): place, finding, expectation, remedy.
function(airside_refuse_topologies found expected)
  message(FATAL_ERROR "AIRSIDE_TOPOLOGIES in ${CMAKE_BINARY_DIR}/CMakeCache.txt: found \"${AIRSIDE_TOPOLOGIES}\", ${found}; "
                      "expected ${expected}; a build folder keeps the list that it was made with: "
                      "run cmake once with -U AIRSIDE_TOPOLOGIES, or remove the folder, and give -DAIRSIDE_TOPOLOGIES "
                      "again where it was meant")
endfunction()

list(JOIN known ", " known_text)
if(NOT AIRSIDE_TOPOLOGIES)
  airside_refuse_topologies("which is empty" "one or more of ${known_text}")
endif()
foreach(tag ${AIRSIDE_TOPOLOGIES})
  if(NOT tag IN_LIST known)
    airside_refuse_topologies("where ${tag} is no topology of lib/airside/topology.hpp" "types from ${known_text}")
  endif()
endforeach()
if(AIRSIDE_HOST AND AIRSIDE_TESTS)
  foreach(tag FiveZone ThreeVav EightVavFourFcu UpTo8 UpTo32)
    if(NOT tag IN_LIST AIRSIDE_TOPOLOGIES)
      airside_refuse_topologies("which lacks ${tag}" "${tag} too, since the tests use it, or AIRSIDE_TESTS=OFF")
    endif()
  endforeach()
endif()
