# What `cmake --install` leaves: libraries and headers for find_package(pleinair), the program, and
# the bundled sequences. Headers are installed below include/pleinair/ and include each other by
# "pleinair/scene/mesh.h", so that no folder's name of ours meets one of the user's.

include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/pleinair)
set(data_dir ${CMAKE_INSTALL_DATADIR}/pleinair)

get_property(libraries GLOBAL PROPERTY PLEINAIR_LIBRARIES)
install(TARGETS ${libraries} EXPORT pleinairTargets)
install(EXPORT pleinairTargets NAMESPACE pleinair:: DESTINATION ${package_dir})

list(TRANSFORM libraries REPLACE "^pleinair_" "" OUTPUT_VARIABLE library_folders)
foreach(folder IN LISTS library_folders)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/pleinair
    FILES_MATCHING PATTERN "*.h" PATTERN internal EXCLUDE PATTERN samples EXCLUDE)
endforeach()
list(JOIN library_folders "|" any_folder)
install(CODE "
  set(include_dir \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}\")
  set(own_include \"#include \\\"((${any_folder})/)\")")
install(CODE [[
  file(GLOB_RECURSE headers ${include_dir}/pleinair/*.h)
  foreach(header IN LISTS headers)
    file(READ ${header} text)
    string(REGEX REPLACE "${own_include}" "#include \"pleinair/\\1" text "${text}")
    file(WRITE ${header} "${text}")
  endforeach()]])

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
