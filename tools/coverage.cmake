# Counters of branches, in the files of tools/coverage_files.txt alone: atomic ones in the loops of lib's algebra would
# make its tests ten times as slow. The list's name has its content in it, so that another list compiles anew.
set(coverage_files ${PROJECT_SOURCE_DIR}/tools/coverage_files.txt)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${coverage_files})
file(STRINGS ${coverage_files} coverage_places REGEX "^[^#]")
list(TRANSFORM coverage_places REPLACE "[ #].*" "")
list(TRANSFORM coverage_places PREPEND "src:${PROJECT_SOURCE_DIR}/")
list(JOIN coverage_places "\n" coverage_places)
string(SHA1 coverage_digest "${coverage_places}")
set(coverage_list ${PROJECT_BINARY_DIR}/coverage-${coverage_digest}.txt)
file(CONFIGURE OUTPUT ${coverage_list} CONTENT "[clang]\n${coverage_places}\n" @ONLY)
add_compile_options(-fprofile-instr-generate -fcoverage-mapping -fprofile-update=atomic -fprofile-list=${coverage_list})
add_link_options(-fprofile-instr-generate)
