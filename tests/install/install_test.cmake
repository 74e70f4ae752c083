# Installs the build to an empty prefix and builds, links and runs consumer/ against that alone; then
# compiles it within subproject/, which has the sources of pleinair in its tree.
cmake_minimum_required(VERSION 3.25)

set(prefix ${WORK_DIR}/prefix)
set(consumer_build ${WORK_DIR}/consumer)
file(REMOVE_RECURSE ${prefix} ${consumer_build})

function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    list(JOIN ARGV " " command)
    message(FATAL_ERROR "failed with ${status}: ${command}")
  endif()
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${prefix})
set(toolchain -G Ninja -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}
  -D CMAKE_EXE_LINKER_FLAGS=${LINKER_FLAGS})
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/consumer -B ${consumer_build} ${toolchain}
  -D CMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${consumer_build})
run(${consumer_build}/consumer)
run(${prefix}/bin/pleinair --version)

# What is folder-private stays here, and no path of this checkout goes along.
file(GLOB_RECURSE internal_headers ${prefix}/include/*/internal/*)
if(internal_headers)
  message(FATAL_ERROR "installed, though folder-private: ${internal_headers}")
endif()
get_filename_component(source_dir ${CMAKE_CURRENT_LIST_DIR}/../.. ABSOLUTE)
file(GLOB package_files ${prefix}/lib*/cmake/pleinair/*.cmake ${prefix}/lib*/*/cmake/pleinair/*.cmake)
if(NOT package_files)
  message(FATAL_ERROR "no package files under ${prefix}")
endif()
foreach(package_file IN LISTS package_files)
  file(READ ${package_file} text)
  foreach(leak IN ITEMS ${source_dir}/ pleinair_flags)
    string(FIND "${text}" "${leak}" found)
    if(NOT found EQUAL -1)
      message(FATAL_ERROR "${package_file} mentions ${leak}")
    endif()
  endforeach()
endforeach()

set(subproject_build ${WORK_DIR}/subproject)
file(REMOVE_RECURSE ${subproject_build})
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/subproject -B ${subproject_build} ${toolchain})
run(${CMAKE_COMMAND} --build ${subproject_build} --target consumer)
# Its strictness is its own: another compiler may warn of what ours does not.
file(READ ${subproject_build}/compile_commands.json commands)
string(REGEX MATCHALL "-Werror" strict "${commands}")
list(LENGTH strict strict_count)
if(NOT strict_count EQUAL 1)
  message(FATAL_ERROR "${strict_count} sources have -Werror: expected consumer/main.cpp alone")
endif()
