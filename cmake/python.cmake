# swiftlet_python_environment(): makes build/python, the virtual environment with the packages of requirements.txt that
# all presets share, unless it is there; sets SWIFTLET_PYTHON to its interpreter.
function(swiftlet_python_environment)
  set(requirements ${PROJECT_SOURCE_DIR}/requirements.txt)
  set(folder ${PROJECT_SOURCE_DIR}/build/python)
  set(SWIFTLET_PYTHON ${folder}/bin/python PARENT_SCOPE)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${requirements})

  file(MAKE_DIRECTORY ${PROJECT_SOURCE_DIR}/build)
  file(LOCK ${PROJECT_SOURCE_DIR}/build/python.lock GUARD FUNCTION TIMEOUT 900)
  file(SHA256 ${requirements} wanted)
  set(stamp ${folder}/requirements.sha256)
  if(EXISTS ${stamp})
    file(READ ${stamp} present)
    if(present STREQUAL wanted)
      return()
    endif()
  endif()

  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  message(STATUS "Python environment: installing requirements.txt into build/python")
  execute_process(COMMAND ${Python3_EXECUTABLE} -m venv --clear ${folder} RESULT_VARIABLE made)
  if(made EQUAL 0)
    execute_process(COMMAND ${folder}/bin/python -m pip install --quiet --disable-pip-version-check
                            --requirement ${requirements} RESULT_VARIABLE made)
  endif()
  if(NOT made EQUAL 0)
    message(FATAL_ERROR "build/python could not be made: install python3-venv (./go setup) and make sure that pip can "
                        "reach its index, or build without the link: -DSWIFTLET_MAVLINK=OFF")
  endif()
  file(WRITE ${stamp} ${wanted})
endfunction()
