# SPDX-License-Identifier: Apache-2.0

# Finds what the libraries are built with: for this project, and for those who use it installed.

# Defines `target` by pkg-config or, where that doesn't know the module, by the package's own CMake
# files. Those of Debian's OpenImageIO and Imath name files of packages that they don't depend on.
# No alias: exported targets that link to one would name what it stands for on this machine.
find_package(PkgConfig)
function(find_library_target target package module least_version)
  if(TARGET ${target})
    return()
  endif()
  if(PkgConfig_FOUND)
    pkg_check_modules(${package} QUIET IMPORTED_TARGET GLOBAL ${module}>=${least_version})
  endif()
  if(TARGET PkgConfig::${package})
    message(STATUS "Found ${package}: ${${package}_VERSION}")
    add_library(${target} INTERFACE IMPORTED GLOBAL)
    target_link_libraries(${target} INTERFACE PkgConfig::${package})
  else()
    find_package(${package} CONFIG REQUIRED GLOBAL)
  endif()
endfunction()

find_library_target(OpenImageIO::OpenImageIO OpenImageIO OpenImageIO 2.4)
find_library_target(OpenEXR::OpenEXR OpenEXR OpenEXR 3.1)
find_library_target(Imath::Imath Imath Imath 3.1)
find_library_target(hwy::hwy hwy libhwy 1.0)
find_library_target(tomlplusplus::tomlplusplus tomlplusplus tomlplusplus 3.0)
find_package(Boost 1.70 CONFIG REQUIRED)
find_package(fmt CONFIG REQUIRED)
find_package(nlohmann_json CONFIG REQUIRED)
find_package(pugixml CONFIG REQUIRED)
find_package(TBB CONFIG REQUIRED)

# The library of OpenImageIO's strings, hashes and curves, without the one that starts all formats.
if(NOT TARGET OpenImageIO::OpenImageIO_Util)
  find_library(OPENIMAGEIO_UTIL OpenImageIO_Util HINTS ${OpenImageIO_LIBRARY_DIRS} REQUIRED)
  add_library(OpenImageIO::OpenImageIO_Util INTERFACE IMPORTED GLOBAL)
  target_include_directories(OpenImageIO::OpenImageIO_Util INTERFACE ${OpenImageIO_INCLUDE_DIRS})
  target_link_libraries(OpenImageIO::OpenImageIO_Util INTERFACE ${OPENIMAGEIO_UTIL})
endif()
