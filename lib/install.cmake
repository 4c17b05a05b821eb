# Component `lib`: headers, archive and find_package(airside COMPONENTS lib), for programs of others.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/airside)
install(TARGETS airside_lib EXPORT airside-lib ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT lib)
install(DIRECTORY ${CMAKE_CURRENT_LIST_DIR}/airside ${PROJECT_BINARY_DIR}/generated/airside
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT lib FILES_MATCHING PATTERN *.hpp)
install(EXPORT airside-lib NAMESPACE airside:: FILE airside-lib-targets.cmake DESTINATION ${package_dir} COMPONENT lib)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/airside-config.cmake.in ${PROJECT_BINARY_DIR}/airside-config.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/airside-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/airside-config.cmake ${PROJECT_BINARY_DIR}/airside-config-version.cmake
        DESTINATION ${package_dir} COMPONENT lib)
