# SPDX-License-Identifier: Apache-2.0

#[[
  plumbline_add_picture_test(NAME name RENDER command...  REFERENCE file
    [TOLERANCE 0.5%] [REGIONS mask] [OPTIONS option...] [EXPECT different])

Adds a test that runs the command, in which {output} stands for the file that it is to write, and
holds that picture against the reference, as 'plumb compare' does with the same options. Files are
relative to the source folder. EXPECT is for companions that prove that the test can fail.
]]
set(_plumbline_picture_test "${CMAKE_CURRENT_LIST_DIR}/run_picture_test.cmake")
function(plumbline_add_picture_test)
  cmake_parse_arguments(PARSE_ARGV 0 test "" "NAME;REFERENCE;TOLERANCE;REGIONS;EXPECT"
    "RENDER;OPTIONS")
  foreach(needed IN ITEMS NAME RENDER REFERENCE)
    if(NOT test_${needed})
      message(FATAL_ERROR "plumbline_add_picture_test() needs ${needed}")
    endif()
  endforeach()
  if(test_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "plumbline_add_picture_test() has no '${test_UNPARSED_ARGUMENTS}'")
  endif()
  set(picture "${CMAKE_CURRENT_BINARY_DIR}/${test_NAME}.exr")
  string(REPLACE "{output}" "${picture}" render "${test_RENDER}")
  cmake_path(ABSOLUTE_PATH test_REFERENCE BASE_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}")
  set(compare "${PLUMBLINE_PLUMB}" compare "${picture}" "${test_REFERENCE}")
  if(test_TOLERANCE)
    list(APPEND compare --tolerance ${test_TOLERANCE})
  endif()
  if(test_REGIONS)
    cmake_path(ABSOLUTE_PATH test_REGIONS BASE_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}")
    list(APPEND compare --regions "${test_REGIONS}")
  endif()
  add_test(NAME "${test_NAME}" COMMAND_EXPAND_LISTS COMMAND ${CMAKE_COMMAND}
    "-DNAME=${test_NAME}" "-DEXPECT=${test_EXPECT}" "-DPICTURE=${picture}"
    -P "${_plumbline_picture_test}" -- plumbline:render ${render}
    plumbline:compare ${compare} ${test_OPTIONS})
endfunction()
