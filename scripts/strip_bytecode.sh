#!/bin/sh
# Removes the compiler's bytecode from the installed static library; run by meson at `meson install`.
# What is left is ordinary code, which compilers of any version link.
#
#   strip_bytecode.sh LIBRARY
#
# LIBRARY is taken below the install prefix.
set -eu

[ $# -eq 1 ] || {
   echo "usage: strip_bytecode.sh LIBRARY" >&2
   exit 2
}
library=${MESON_INSTALL_DESTDIR_PREFIX:?is set by meson install}/$1

[ -z "${MESON_INSTALL_DRY_RUN:-}" ] || exit 0
objcopy --remove-section='.gnu.lto_*' --remove-section='.gnu.debuglto_*' \
   --strip-symbol=__gnu_lto_v1 "$library"
