# The package that find_package(swiftlet) finds: targets swiftlet::core, swiftlet::hal and swiftlet::mavlink.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/swiftlet)
install(TARGETS swiftlet_core swiftlet_hal EXPORT swiftlet)
install(DIRECTORY firmware_core/include/ hal/include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(FILES ${SWIFTLET_GENERATED_INCLUDE}/swiftlet/version.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/swiftlet)
if(SWIFTLET_MAVLINK)
  install(TARGETS swiftlet_mavlink EXPORT swiftlet)
endif()
install(EXPORT swiftlet NAMESPACE swiftlet:: DESTINATION ${package_dir})
install(FILES cmake/swiftlet-config.cmake DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/swiftlet-config-version.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/swiftlet-config-version.cmake DESTINATION ${package_dir})
