#!/bin/sh
# Installs the Fortran module files of the library; run by meson at `meson install`.
#
#   install_modules.sh FOLDER DESTINATION
#
# FOLDER holds the *.mod files that the compiler wrote; DESTINATION is taken below the install prefix.
set -eu

[ $# -eq 2 ] || {
   echo "usage: install_modules.sh FOLDER DESTINATION" >&2
   exit 2
}
folder=$1
destination=${MESON_INSTALL_DESTDIR_PREFIX:?is set by meson install}/$2

set -- "$folder"/*.mod
[ -e "$1" ] || {
   echo "install_modules.sh: no module files in $folder" >&2
   exit 1
}
[ -z "${MESON_INSTALL_DRY_RUN:-}" ] || exit 0
mkdir -p -- "$destination"
install -m 644 -- "$@" "$destination/"
[ -n "${MESON_INSTALL_QUIET:-}" ] || echo "Installing $# module files to $destination"
