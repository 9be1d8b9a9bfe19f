# SPDX-License-Identifier: Apache-2.0

# Read by find_package(plumbline): defines plumbline::images, plumbline::renderer,
# plumbline::scene_files and plumbline::compare.
include("${CMAKE_CURRENT_LIST_DIR}/libraries.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/plumblineTargets.cmake")
