# The check of AIRSIDE_TOPOLOGIES as a build with hosts and tests makes it; TAGS: the cached list, comma-separated.
cmake_minimum_required(VERSION 3.25)
string(REPLACE "," ";" AIRSIDE_TOPOLOGIES "${TAGS}")
set(AIRSIDE_HOST ON)
set(AIRSIDE_TESTS ON)
include(${CMAKE_CURRENT_LIST_DIR}/../../lib/check_topologies.cmake)
