# What a program that embeds the library needs: headers, both libraries, a pkg-config file and a CMake package. Paths in
# them are relative, so an installed tree can be moved.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/stipple)

file(GLOB STP_PUBLIC_HEADERS CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/include/stipple/*.h)

install(TARGETS stipple ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS stipple_shared EXPORT stipple-targets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(FILES ${STP_PUBLIC_HEADERS} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/stipple)

install(EXPORT stipple-targets NAMESPACE stipple:: DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/stipple-config-version.cmake COMPATIBILITY SameMinorVersion)
configure_file(${CMAKE_CURRENT_LIST_DIR}/stipple-config.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/stipple-config.cmake @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/stipple-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/stipple-config-version.cmake
        DESTINATION ${package_dir})

# pkg-config finds the prefix from where the file lies.
cmake_path(RELATIVE_PATH CMAKE_INSTALL_PREFIX BASE_DIRECTORY ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig
           OUTPUT_VARIABLE prefix_from_file)
configure_file(${CMAKE_CURRENT_LIST_DIR}/stipple.pc.in ${CMAKE_CURRENT_BINARY_DIR}/stipple.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/stipple.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
