# What a plain `cmake --install` puts below its prefix beside lib: component `host`. Nothing goes outside the prefix; the
# box's package is another component (firmware/packaging).
set(programs airsided)
foreach(program airside airside-page airside-mqtt airside-energyplus)
  if(TARGET ${program})
    list(APPEND programs ${program})
  endif()
endforeach()
if(AIRSIDE_BOX)
  list(APPEND programs airside-box)
endif()
install(TARGETS ${programs} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT host)
install(FILES ${PROJECT_SOURCE_DIR}/firmware/packaging/site.toml ${PROJECT_SOURCE_DIR}/firmware/packaging/points.csv
        DESTINATION ${CMAKE_INSTALL_DATADIR}/airside/examples COMPONENT host)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs/examples/ DESTINATION ${CMAKE_INSTALL_DATADIR}/airside/examples COMPONENT host)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT host)
if(NOT TARGET airside)
  return()
endif()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/sim/models/ DESTINATION ${CMAKE_INSTALL_DATADIR}/airside/models COMPONENT host)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/sim/effects/library DESTINATION ${CMAKE_INSTALL_DATADIR}/airside/effects COMPONENT host)

# Man pages from --help, and completion from the options that the programs really have: they are run for both.
find_package(Python3 COMPONENTS Interpreter)
if(CMAKE_CROSSCOMPILING OR NOT Python3_FOUND OR CMAKE_CXX_FLAGS MATCHES "-fsanitize" OR AIRSIDE_COVERAGE)
  message(STATUS "no man pages and no completion: they take programs that run here, without sanitizers, and python3")
  return()
endif()
set(words_dir ${PROJECT_BINARY_DIR}/words)
set(plain_programs $<TARGET_FILE:airsided>)
foreach(program airside-page airside-mqtt)
  if(TARGET ${program})
    list(APPEND plain_programs $<TARGET_FILE:${program}>)
  endif()
endforeach()
set(words_programs $<TARGET_FILE:airside> ${plain_programs})
add_custom_command(
  OUTPUT ${words_dir}/stamp
  COMMAND ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}/tools/man_pages ${words_dir}/man/man1 ${words_programs}
  COMMAND ${CMAKE_COMMAND} -E make_directory ${words_dir}/bash ${words_dir}/zsh
  COMMAND airside completion bash -o ${words_dir}/bash/airside
  COMMAND airside completion zsh -o ${words_dir}/zsh/_airside
  COMMAND ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}/tools/plain_completion ${words_dir}/bash ${words_dir}/zsh ${plain_programs}
  COMMAND ${CMAKE_COMMAND} -E touch ${words_dir}/stamp
  DEPENDS ${PROJECT_SOURCE_DIR}/tools/man_pages ${PROJECT_SOURCE_DIR}/tools/plain_completion ${words_programs}
  COMMENT "Man pages and completion"
  VERBATIM)
add_custom_target(airside_words ALL DEPENDS ${words_dir}/stamp)
install(DIRECTORY ${words_dir}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT host)
install(DIRECTORY ${words_dir}/bash/ DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT host)
install(DIRECTORY ${words_dir}/zsh/ DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions COMPONENT host)
