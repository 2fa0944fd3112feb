# swiftlet_core_test(NAME SOURCES...): tests of the core and hal that run on every machine.
# swiftlet_host_test(NAME SOURCES... [LIBS ...]): GoogleTest on the host.

set(GTEST_HAS_ABSL OFF)
set(INSTALL_GTEST OFF)
set(BUILD_GMOCK OFF)
find_path(SWIFTLET_GOOGLETEST CMakeLists.txt PATHS /usr/src/googletest NO_CMAKE_FIND_ROOT_PATH REQUIRED)
enable_language(C)  # GoogleTest's project asks for it
add_subdirectory(${SWIFTLET_GOOGLETEST} ${PROJECT_BINARY_DIR}/googletest EXCLUDE_FROM_ALL SYSTEM)

function(swiftlet_host_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" LIBS)
  add_executable(${name} ${arg_UNPARSED_ARGUMENTS})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/harness ${PROJECT_SOURCE_DIR}/tests)
  target_compile_definitions(${name} PRIVATE SWIFTLET_PROPERTY_RUNS=${SWIFTLET_PROPERTY_RUNS}
                                             SWIFTLET_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  target_link_libraries(${name} PRIVATE ${arg_LIBS} swiftlet_board swiftlet_warnings GTest::gtest_main)
  add_test(NAME ${SWIFTLET_TEST_PREFIX}.${name} COMMAND ${name})
  set_tests_properties(${SWIFTLET_TEST_PREFIX}.${name} PROPERTIES TIMEOUT 300)
endfunction()

function(swiftlet_core_test name)
  swiftlet_host_test(${name} ${ARGN})
endfunction()
