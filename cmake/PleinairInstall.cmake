# What `cmake --install` leaves: libraries and headers for find_package(pleinair), the program, and
# the bundled sequences. The folders stay as they are here, so an include reads the same everywhere.

include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/pleinair)
set(data_dir ${CMAKE_INSTALL_DATADIR}/pleinair)

get_property(libraries GLOBAL PROPERTY PLEINAIR_LIBRARIES)
install(TARGETS ${libraries} EXPORT pleinairTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT pleinairTargets NAMESPACE pleinair:: DESTINATION ${package_dir})

list(TRANSFORM libraries REPLACE "^pleinair_" "" OUTPUT_VARIABLE library_folders)
foreach(folder IN LISTS library_folders)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder} DESTINATION include/pleinair
    FILES_MATCHING PATTERN "*.h" PATTERN internal EXCLUDE PATTERN samples EXCLUDE)
endforeach()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/pleinairConfig.cmake.in
  ${PROJECT_BINARY_DIR}/pleinairConfig.cmake
  INSTALL_DESTINATION ${package_dir} PATH_VARS CMAKE_INSTALL_DATADIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/pleinairConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/pleinairConfig.cmake
  ${PROJECT_BINARY_DIR}/pleinairConfigVersion.cmake
  DESTINATION ${package_dir})

install(DIRECTORY ${PROJECT_SOURCE_DIR}/datasets/samples DESTINATION ${data_dir})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${data_dir})
install(FILES ${PROJECT_SOURCE_DIR}/docs/licences.md DESTINATION ${data_dir} RENAME NOTICES.md)
