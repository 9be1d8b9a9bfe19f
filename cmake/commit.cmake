# SPDX-License-Identifier: Apache-2.0

# Sets `commit` to what is built: git knows it of a clone, and filled it in below in an archive.
set(commit "$Format:%h$")
if(commit MATCHES Format)
  set(commit unknown)
  find_package(Git QUIET)
  if(GIT_FOUND)
    execute_process(
      COMMAND ${GIT_EXECUTABLE} rev-parse --git-path logs/HEAD --short HEAD
      WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}
      OUTPUT_VARIABLE said RESULT_VARIABLE failed ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
  endif()
  if(GIT_FOUND AND NOT failed)
    string(REGEX REPLACE "[\r\n]+" ";" said "${said}")
    list(GET said 0 log)
    list(GET said 1 commit)
    file(REAL_PATH ${log} log BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
    if(EXISTS ${log})
      set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${log})
    endif()
  endif()
endif()
