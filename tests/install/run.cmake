# cmake -DBUILD=<build folder> -DFOLDER=<scratch> -DCOMPILER=<c++> -P run.cmake: installs the package into an empty
# prefix, then configures, builds and runs the project beside this file against it.
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${FOLDER})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${FOLDER}/prefix)
file(READ ${CMAKE_CURRENT_LIST_DIR}/../../README.md readme)
if(NOT readme MATCHES "```cpp\n([^`]*)```")
  message(FATAL_ERROR "README.md has no C++ example")
endif()
file(WRITE ${FOLDER}/readme_example.cpp "${CMAKE_MATCH_1}")
run(${CMAKE_COMMAND} -G Ninja -S ${CMAKE_CURRENT_LIST_DIR} -B ${FOLDER}/build -DCMAKE_PREFIX_PATH=${FOLDER}/prefix
    -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_BUILD_TYPE=Release
    -DREADME_EXAMPLE=${FOLDER}/readme_example.cpp)
run(${CMAKE_COMMAND} --build ${FOLDER}/build)
run(${FOLDER}/build/example)
