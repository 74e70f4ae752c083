# How every target of ours is made: warnings are errors, flags sit on targets.

add_library(pleinair_flags INTERFACE)
target_compile_options(pleinair_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor
  -Woverloaded-virtual -Werror)
if(PLEINAIR_SANITIZE)
  target_compile_options(pleinair_flags INTERFACE
    -fsanitize=${PLEINAIR_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(pleinair_flags INTERFACE -fsanitize=${PLEINAIR_SANITIZE})
endif()

# pleinair_add_library(<folder> SOURCES ... [PUBLIC libs...] [PRIVATE libs...])
# PUBLIC are libraries that appear in the folder's headers.
function(pleinair_add_library folder)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(pleinair_${folder} STATIC ${ARG_SOURCES})
  add_library(pleinair::${folder} ALIAS pleinair_${folder})
  set_target_properties(pleinair_${folder} PROPERTIES EXPORT_NAME ${folder})
  target_compile_features(pleinair_${folder} PUBLIC cxx_std_20)
  target_include_directories(pleinair_${folder} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:include/pleinair>)
  target_link_libraries(pleinair_${folder}
    PUBLIC ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE} $<BUILD_INTERFACE:pleinair_flags>)
  set_property(GLOBAL APPEND PROPERTY PLEINAIR_LIBRARIES pleinair_${folder})
endfunction()

# pleinair_add_test(<folder> [WHOLE] SOURCES ... [LIBS ...] [PRECOMPILE ...]): one test program a
# folder, tests/<folder>/. Each test is run by itself; WHOLE runs the program once, for tests that
# share a costly beginning. PRECOMPILE are headers to read once for all sources, beside GoogleTest's:
# reading took half of the time to build the tests. Sources still include what they use.
function(pleinair_add_test folder)
  cmake_parse_arguments(ARG "WHOLE" "" "SOURCES;LIBS;PRECOMPILE" ${ARGN})
  add_executable(pleinair_${folder}_tests ${ARG_SOURCES})
  target_precompile_headers(pleinair_${folder}_tests PRIVATE
    <algorithm> <array> <cmath> <filesystem> <fstream> <random> <string> <vector>
    <glm/geometric.hpp> <glm/mat4x4.hpp> <glm/vec3.hpp>
    <gmock/gmock.h> <gtest/gtest.h>
    ${ARG_PRECOMPILE})
  # Most of a test's own code runs once.
  target_compile_options(pleinair_${folder}_tests PRIVATE $<$<CONFIG:Release>:-O1>)
  target_link_libraries(pleinair_${folder}_tests PRIVATE
    ${ARG_LIBS} GTest::gmock GTest::gtest_main pleinair_flags)
  # Where the recordings and reference data stand, when they are there; tests skip when they aren't.
  target_compile_definitions(pleinair_${folder}_tests PRIVATE
    PLEINAIR_SHARED_DIR="${PROJECT_SOURCE_DIR}/../shared" PLEINAIR_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  if(ARG_WHOLE)
    add_test(NAME ${folder}.All COMMAND pleinair_${folder}_tests)
    set_tests_properties(${folder}.All PROPERTIES LABELS ${folder} TIMEOUT 300)
  else()
    gtest_discover_tests(pleinair_${folder}_tests DISCOVERY_MODE PRE_TEST
      PROPERTIES LABELS ${folder} TIMEOUT 300)
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
