#!/bin/sh
# SPDX-License-Identifier: Apache-2.0

# Installs the Debian package that PACKAGE names, a file or a URL; else that of the release TAG.
set -eu
root=$(test "$(id -u)" = 0 || echo sudo)
install() { $root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "$@"; }

$root apt-get update -q
if [ -z "$PACKAGE" ]; then
  . /etc/os-release
  architecture=$(dpkg --print-architecture)
  PACKAGE=$RELEASES/$TAG/plumbline_${TAG#v}-1.$ID${VERSION_ID}_$architecture.deb
fi
case $PACKAGE in
  *://*)
    command -v curl >/dev/null || install ca-certificates curl
    folder=$(mktemp -d)
    curl -fsSL -o "$folder/plumbline.deb" "$PACKAGE"
    chmod -R a+rX "$folder"
    PACKAGE=$folder/plumbline.deb ;;
esac
install "$(realpath "$PACKAGE")"
plumb --version --verbose
