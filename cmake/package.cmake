# SPDX-License-Identifier: Apache-2.0

# What CPack makes of the installation, for `make package`: a Debian package of the program and one
# of the libraries. Each is for the release that it is built on, whose libraries it needs.
cmake_host_system_information(RESULT system QUERY DISTRIB_INFO)
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_COMPONENTS_ALL program libraries)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/debian_documents.cmake)

set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_DEBIAN_PACKAGE_RELEASE 1.${system_ID}${system_VERSION_ID})
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "The Plumbline authors <maintainers@plumbline.example>")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "reference path tracer that knows how wrong its pictures are")

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME plumbline)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
  "Renders small scenes without bias, measures the noise of every pixel, and
tells whether two pictures, by any program, differ by more than noise.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS gnuplot-nox)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "povray, blender")

set(CPACK_DEBIAN_LIBRARIES_PACKAGE_NAME libplumbline-dev)
set(CPACK_COMPONENT_LIBRARIES_DESCRIPTION
  "The libraries for C++: the renderer, the reader of scenes and the comparison
of pictures, to be found by CMake.")
set(CPACK_DEBIAN_LIBRARIES_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBRARIES_PACKAGE_DEPENDS
  "plumbline (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}), libboost-math-dev, libfmt-dev, libhwy-dev, libimath-dev, libopenexr-dev, libopenimageio-dev, libpugixml-dev, libtbb-dev, libtomlplusplus-dev, nlohmann-json3-dev")
include(CPack)
