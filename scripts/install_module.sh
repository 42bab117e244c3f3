#!/bin/sh
# Installs the Fortran module file of the library; run by meson at `meson install`.
#
#   install_module.sh FILE DESTINATION
#
# FILE is what the compiler wrote; DESTINATION is a folder below the install prefix.
set -eu

[ $# -eq 2 ] || {
   echo "usage: install_module.sh FILE DESTINATION" >&2
   exit 2
}
destination=${MESON_INSTALL_DESTDIR_PREFIX:?is set by meson install}/$2

[ -z "${MESON_INSTALL_DRY_RUN:-}" ] || exit 0
mkdir -p -- "$destination"
install -m 644 -- "$1" "$destination/"
[ -n "${MESON_INSTALL_QUIET:-}" ] || echo "Installing $1 to $destination"
