# Tests are named <preset>.<name>, the preset being the name of the build folder.
#
# swiftlet_core_test(NAME SOURCES... [LIBS ...]): tests of core and hal that run on every machine. Hosted boards get one GoogleTest
#   program each, a bare board one image of them all, `core_tests`.
# swiftlet_host_test(NAME SOURCES... [LIBS ...]): GoogleTest on hosted boards.
# swiftlet_test_definitions(TARGET): include paths, definitions and warnings of a test program.

cmake_path(GET PROJECT_BINARY_DIR FILENAME SWIFTLET_TEST_PREFIX)
set(SWIFTLET_PROPERTY_RUNS 100 CACHE STRING "Random cases of a property test: 2000 in host-release")
set(SWIFTLET_TEST_SECONDS 600 CACHE STRING "Time limit of each test [s]")

# Expected values are written as doubles and serve both kinds of Real. Linked last: the last option wins.
add_library(swiftlet_test_warnings INTERFACE)
target_compile_options(swiftlet_test_warnings INTERFACE -Wno-double-promotion -Wno-float-conversion)

function(swiftlet_test_definitions target)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/tests/harness ${PROJECT_SOURCE_DIR}/tests)
  target_compile_definitions(${target} PRIVATE SWIFTLET_PROPERTY_RUNS=${SWIFTLET_PROPERTY_RUNS}
                                               SWIFTLET_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  target_link_libraries(${target} PRIVATE swiftlet_board swiftlet_warnings swiftlet_test_warnings)
endfunction()

# swiftlet_add_test(NAME COMMAND...): add_test with prefix and timeout.
function(swiftlet_add_test name)
  add_test(NAME ${SWIFTLET_TEST_PREFIX}.${name} COMMAND ${ARGN} COMMAND_EXPAND_LISTS)
  set_tests_properties(${SWIFTLET_TEST_PREFIX}.${name} PROPERTIES TIMEOUT ${SWIFTLET_TEST_SECONDS})
endfunction()

if(CMAKE_SYSTEM_NAME STREQUAL Generic)
  add_executable(core_tests harness/bare_test.cpp)
  target_compile_definitions(core_tests PRIVATE SWIFTLET_BARE_TEST)
  swiftlet_test_definitions(core_tests)
  swiftlet_add_test(core_tests core_tests)

  function(swiftlet_core_test name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "" LIBS)
    target_sources(core_tests PRIVATE ${arg_UNPARSED_ARGUMENTS})
    target_link_libraries(core_tests PRIVATE ${arg_LIBS})
  endfunction()
else()
  find_path(SWIFTLET_GOOGLETEST CMakeLists.txt PATHS /usr/src/googletest NO_CMAKE_FIND_ROOT_PATH REQUIRED)
  set(INSTALL_GTEST OFF)
  set(BUILD_GMOCK OFF)
  enable_language(C)  # GoogleTest's project asks for it
  add_subdirectory(${SWIFTLET_GOOGLETEST} ${PROJECT_BINARY_DIR}/googletest EXCLUDE_FROM_ALL SYSTEM)

  function(swiftlet_host_test name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "" LIBS)
    add_executable(${name} ${arg_UNPARSED_ARGUMENTS})
    target_link_libraries(${name} PRIVATE ${arg_LIBS} GTest::gtest_main)
    swiftlet_test_definitions(${name})
    swiftlet_add_test(${name} ${name})
  endfunction()

  function(swiftlet_core_test name)
    swiftlet_host_test(${name} ${ARGN})
  endfunction()
endif()
