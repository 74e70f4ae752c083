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
# Nobody asks errno for what a root said; without it several roots are taken at a time.
target_compile_options(pleinair_flags INTERFACE -fno-math-errno)
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

# Other projects' headers, read once for all that is compiled with the same options: reading them
# took half of the build. GCC takes the level of optimisation from what it has read, thus a set for
# each level. Sources still include what they use: preset clang builds the libraries without sets.
set(pleinair_common_headers
  <algorithm> <array> <charconv> <chrono> <cmath> <filesystem> <fstream> <functional> <map>
  <memory> <mutex> <numeric> <optional> <random> <set> <span> <sstream> <string> <thread>
  <unordered_map> <variant> <vector>
  <Eigen/Core> <fmt/format.h>
  <glm/common.hpp> <glm/geometric.hpp> <glm/mat3x3.hpp> <glm/mat4x4.hpp> <glm/matrix.hpp> <glm/vec2.hpp>
  <glm/vec3.hpp> <glm/vec4.hpp>
  <nlohmann/json.hpp> <tbb/parallel_for.h> <tl/expected.hpp>)
add_library(pleinair_common_headers_use INTERFACE)
target_link_libraries(pleinair_common_headers_use INTERFACE
  Eigen3::Eigen fmt::fmt glm::glm nlohmann_json::nlohmann_json TBB::tbb tl::expected)

# pleinair_add_headers(<name> FLAGS <target> [PROGRAM] [ALSO headers...] [LIBS ...]): a set for
# libraries, or programs, that link FLAGS. ALSO needs LIBS.
function(pleinair_add_headers name)
  cmake_parse_arguments(ARG "PROGRAM" "FLAGS" "ALSO;LIBS" ${ARGN})
  if(ARG_PROGRAM)
    add_executable(pleinair_${name} ${PROJECT_SOURCE_DIR}/cmake/headers.cpp)
  else()
    add_library(pleinair_${name} OBJECT ${PROJECT_SOURCE_DIR}/cmake/headers.cpp)
  endif()
  target_precompile_headers(pleinair_${name} PRIVATE ${pleinair_common_headers} ${ARG_ALSO})
  target_link_libraries(pleinair_${name} PRIVATE
    pleinair_common_headers_use ${ARG_LIBS} ${ARG_FLAGS})
endfunction()

# pleinair_build_together(<target> <name>): in large units, with the set of that name.
function(pleinair_build_together target name)
  if(CMAKE_UNITY_BUILD)
    set_target_properties(${target} PROPERTIES UNITY_BUILD_BATCH_SIZE 20)
    target_precompile_headers(${target} REUSE_FROM pleinair_${name})
    target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:pleinair_common_headers_use>)
  endif()
endfunction()

# For what takes negligible time, as most of a test's own code does: optimising it would take a
# good part of the build.
add_library(pleinair_cold_flags INTERFACE)
target_compile_options(pleinair_cold_flags INTERFACE $<$<CONFIG:Release>:-O1>)
target_link_libraries(pleinair_cold_flags INTERFACE pleinair_flags)

pleinair_add_headers(library_headers FLAGS pleinair_flags)
pleinair_add_headers(cold_library_headers FLAGS pleinair_cold_flags)

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
  pleinair_build_together(pleinair_${folder} library_headers)
  set_property(GLOBAL APPEND PROPERTY PLEINAIR_LIBRARIES pleinair_${folder})
endfunction()

# Seconds, on a busy machine: of one program of many tests, and of a test by itself.
set(pleinair_program_timeout 1200)
set(pleinair_test_timeout 300)
if(PLEINAIR_SANITIZE)
  set(pleinair_program_timeout 3600)
  set(pleinair_test_timeout 1200)
endif()

# pleinair_add_test(<folder> [SHARDS n] [COST s] SOURCES ... [LIBS ...]): one test program per folder,
# tests/<folder>/, run once for all of its tests. To start it takes longer than most tests do, and
# tests of one suite share their set-up. SHARDS divides it into programs that run side by side, for
# tests that wait much or take long, without an expensive set-up. COST is what a shard takes, in
# seconds: a first run begins with the longest.
function(pleinair_add_test folder)
  cmake_parse_arguments(ARG "" "SHARDS;COST" "SOURCES;LIBS" ${ARGN})
  add_executable(pleinair_${folder}_tests ${ARG_SOURCES})
  target_precompile_headers(pleinair_${folder}_tests REUSE_FROM pleinair_test_headers)
  target_link_libraries(pleinair_${folder}_tests PRIVATE
    ${ARG_LIBS} pleinair_common_headers_use GTest::gmock GTest::gtest_main pleinair_cold_flags)
  # Where the recordings and reference data stand, when they are there; tests skip when they aren't.
  target_compile_definitions(pleinair_${folder}_tests PRIVATE
    PLEINAIR_SHARED_DIR="${PROJECT_SOURCE_DIR}/../shared" PLEINAIR_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  if(NOT ARG_SHARDS)
    set(ARG_SHARDS 1)
  endif()
  if(NOT ARG_COST)
    set(ARG_COST 10)
  endif()
  foreach(shard RANGE 1 ${ARG_SHARDS})
    set(name ${folder}.All)
    set(environment)
    if(ARG_SHARDS GREATER 1)
      set(name ${folder}.Shard${shard}Of${ARG_SHARDS})
      math(EXPR index "${shard} - 1")
      set(environment "GTEST_TOTAL_SHARDS=${ARG_SHARDS};GTEST_SHARD_INDEX=${index}")
    endif()
    add_test(NAME ${name} COMMAND pleinair_${folder}_tests --gtest_brief=1)
    set_tests_properties(${name} PROPERTIES
      LABELS ${folder} TIMEOUT ${pleinair_program_timeout} COST ${ARG_COST}
      ENVIRONMENT "${environment}")
  endforeach()
endfunction()

# pleinair_add_bench(<name> SOURCES ... [LIBS ...])
function(pleinair_add_bench name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(pleinair_${name} ${ARG_SOURCES})
  target_link_libraries(pleinair_${name} PRIVATE ${ARG_LIBS} benchmark::benchmark pleinair_cold_flags)
  pleinair_build_together(pleinair_${name} program_headers)
  add_dependencies(pleinair_benches pleinair_${name})
  target_compile_definitions(pleinair_${name} PRIVATE
    PLEINAIR_SHARED_DIR="${PROJECT_SOURCE_DIR}/../shared" PLEINAIR_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endfunction()
