# SPDX-License-Identifier: Apache-2.0

# Read by find_package(plumbline): defines plumbline_add_picture_test() and the libraries
# plumbline::images, plumbline::renderer, plumbline::scene_files, plumbline::compare and so on. With COMPONENTS tests it leaves out the libraries and what they need.
find_program(PLUMBLINE_PLUMB plumb HINTS "${CMAKE_CURRENT_LIST_DIR}/@bin_from_package@")
include("${CMAKE_CURRENT_LIST_DIR}/PictureTest.cmake")
if(NOT plumbline_FIND_COMPONENTS STREQUAL "tests")
  if(EXISTS "${CMAKE_CURRENT_LIST_DIR}/plumblineTargets.cmake")
    include("${CMAKE_CURRENT_LIST_DIR}/libraries.cmake")
    include("${CMAKE_CURRENT_LIST_DIR}/plumblineTargets.cmake")
  else()
    set(plumbline_FOUND FALSE)
    set(plumbline_NOT_FOUND_MESSAGE "its libraries are in the package libplumbline-dev")
  endif()
endif()
