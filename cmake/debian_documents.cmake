# SPDX-License-Identifier: Apache-2.0

# Run by CPack before it packs what it has installed: Debian wants manual pages and changelogs
# compressed, the licence of each package, and zsh's completions in another folder.

# Without these CPack makes packages that depend on nothing, and says so in passing.
find_program(FILE file REQUIRED)
find_program(SHLIBDEPS dpkg-shlibdeps REQUIRED)

string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(GLOB packages "${CPACK_TEMPORARY_DIRECTORY}/*")
foreach(package IN LISTS packages)
  set(name plumbline)
  if(package MATCHES "libraries$")
    set(name libplumbline-dev)
  endif()
  set(share "${package}/usr/share")
  set(documents "${share}/doc/${name}")
  file(WRITE "${documents}/copyright"
    "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\n"
    "Upstream-Name: Plumbline\n\n"
    "Files: *\nCopyright: 2026 The Plumbline authors\nLicense: Apache-2.0\n"
    " On Debian systems, the whole text is in /usr/share/common-licenses/Apache-2.0.\n")
  file(WRITE "${documents}/changelog.Debian"
    "plumbline (${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}) unstable; urgency=medium\n\n"
    "  * Built by `make package`. What has changed is in changelog.gz.\n\n"
    " -- ${CPACK_DEBIAN_PACKAGE_MAINTAINER}  ${date}\n")
  file(COPY_FILE "${CMAKE_CURRENT_LIST_DIR}/../CHANGELOG.md" "${documents}/changelog")
  file(GLOB pages "${share}/man/man1/*.1")
  execute_process(COMMAND gzip -9nf "${documents}/changelog" "${documents}/changelog.Debian" ${pages}
    COMMAND_ERROR_IS_FATAL ANY)
  if(EXISTS "${share}/zsh/site-functions")
    file(RENAME "${share}/zsh/site-functions" "${share}/zsh/vendor-completions")
  endif()
endforeach()
