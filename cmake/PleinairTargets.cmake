# How every target of ours is made: flags sit on targets.

include(GNUInstallDirs)

if(NOT PROJECT_IS_TOP_LEVEL)
  set(CMAKE_COMPILE_WARNING_AS_ERROR OFF)  # Another project's strictness is for its own sources.
endif()
add_library(pleinair_flags INTERFACE)
target_compile_options(pleinair_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor
  -Woverloaded-virtual $<$<BOOL:${PLEINAIR_WARNINGS_AS_ERRORS}>:-Werror>)
# The compiler else stops to collect its own garbage every few seconds: a tenth of the build.
target_compile_options(pleinair_flags INTERFACE
  $<$<CXX_COMPILER_ID:GNU>:SHELL:--param ggc-min-heapsize=1048576>)
# It takes sources that are built together for one header.
target_compile_options(pleinair_flags INTERFACE
  $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
if(PLEINAIR_SANITIZE)
  target_compile_options(pleinair_flags INTERFACE
    -fsanitize=${PLEINAIR_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all
    # With sanitizers GCC 12 raises this warning where nothing is wrong, inside <regex> for one.
    $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(pleinair_flags INTERFACE -fsanitize=${PLEINAIR_SANITIZE})
endif()

# Programs and shared libraries find the libraries beside them, wherever they are installed.
file(RELATIVE_PATH libraries_from_programs
  ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
set(CMAKE_INSTALL_RPATH $ORIGIN $ORIGIN/${libraries_from_programs})

# pleinair_add_library(<folder> SOURCES ... [PUBLIC libs...] [PRIVATE libs...])
# PUBLIC are libraries that appear in the folder's headers.
function(pleinair_add_library folder)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(pleinair_${folder} ${ARG_SOURCES})
  add_library(pleinair::${folder} ALIAS pleinair_${folder})
  # A version without promises yet: a program needs the very minor version that it was linked with.
  set_target_properties(pleinair_${folder} PROPERTIES
    EXPORT_NAME ${folder}
    VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  target_compile_features(pleinair_${folder} PUBLIC cxx_std_20)
  # Users write "pleinair/scene/mesh.h", from the build folder as from an installed package.
  file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/include/pleinair)
  file(CREATE_LINK ${PROJECT_SOURCE_DIR}/${folder} ${PROJECT_BINARY_DIR}/include/pleinair/${folder}
    SYMBOLIC)
  target_include_directories(pleinair_${folder} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(pleinair_${folder}
    PUBLIC ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE} $<BUILD_INTERFACE:pleinair_flags>)
  set_property(GLOBAL APPEND PROPERTY PLEINAIR_LIBRARIES pleinair_${folder})
endfunction()

# Most of a test's own code runs once.
add_library(pleinair_test_flags INTERFACE)
target_compile_options(pleinair_test_flags INTERFACE $<$<CONFIG:Release>:-O1>)
target_link_libraries(pleinair_test_flags INTERFACE pleinair_flags)

# Headers that are read once for all tests: reading took half of the time to build them. Sources
# still include what they use.
function(pleinair_add_test_headers)
  # A program as the tests are: what is read must be compiled as they are.
  add_executable(pleinair_test_headers test_headers.cpp)
  target_precompile_headers(pleinair_test_headers PRIVATE
    <algorithm> <array> <cmath> <filesystem> <fstream> <random> <string> <vector>
    <Eigen/Core>
    <glm/geometric.hpp> <glm/mat4x4.hpp> <glm/vec3.hpp>
    <gmock/gmock.h> <gtest/gtest.h>
    <nlohmann/json.hpp>)
  target_link_libraries(pleinair_test_headers PRIVATE
    pleinair::scene Eigen3::Eigen nlohmann_json::nlohmann_json GTest::gmock pleinair_test_flags)
endfunction()

# Seconds, on a busy machine.
set(pleinair_test_timeout 300)
if(PLEINAIR_SANITIZE)
  set(pleinair_test_timeout 1200)
endif()

# pleinair_add_test(<folder> [WHOLE] SOURCES ... [LIBS ...]): one test program per folder,
# tests/<folder>/. Each test is run by itself; WHOLE runs the program once, for tests that share an
# expensive set-up.
function(pleinair_add_test folder)
  cmake_parse_arguments(ARG "WHOLE" "" "SOURCES;LIBS" ${ARGN})
  add_executable(pleinair_${folder}_tests ${ARG_SOURCES})
  target_precompile_headers(pleinair_${folder}_tests REUSE_FROM pleinair_test_headers)
  target_link_libraries(pleinair_${folder}_tests PRIVATE
    ${ARG_LIBS} Eigen3::Eigen nlohmann_json::nlohmann_json GTest::gmock GTest::gtest_main
    pleinair_test_flags)
  # Where the recordings and reference data stand, when they are there; tests skip when they aren't.
  target_compile_definitions(pleinair_${folder}_tests PRIVATE
    PLEINAIR_SHARED_DIR="${PROJECT_SOURCE_DIR}/../shared" PLEINAIR_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  if(ARG_WHOLE)
    add_test(NAME ${folder}.All COMMAND pleinair_${folder}_tests)
    # Together its tests may take, on a busy machine, what several would.
    set_tests_properties(${folder}.All PROPERTIES LABELS ${folder} TIMEOUT 1200)
  else()
    gtest_discover_tests(pleinair_${folder}_tests DISCOVERY_MODE PRE_TEST
      PROPERTIES LABELS ${folder} TIMEOUT ${pleinair_test_timeout})
  endif()
endfunction()

# pleinair_add_bench(<name> SOURCES ... [LIBS ...])
function(pleinair_add_bench name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(pleinair_${name} ${ARG_SOURCES})
  target_link_libraries(pleinair_${name} PRIVATE ${ARG_LIBS} benchmark::benchmark pleinair_flags)
  target_compile_definitions(pleinair_${name} PRIVATE
    PLEINAIR_SHARED_DIR="${PROJECT_SOURCE_DIR}/../shared" PLEINAIR_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endfunction()
