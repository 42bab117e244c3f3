#!/bin/sh
# Writes the linker's list of what a shared library shows: the functions of the C header, and what
# patterns name beside these.
#
#   exports.sh include/contensou.h [PATTERN...] >exports.map
set -eu

[ $# -ge 1 ] || {
   echo "usage: exports.sh HEADER [PATTERN...]" >&2
   exit 2
}
names=$(sed -e 's:/\*.*\*/::' -e '/^ *\*/d' -e '/^ *\/\*/d' "$1" |
   grep -oE '\bcontensou_[a-z0-9_]+\(' | tr -d '(' | sort -u)
[ -n "$names" ]
shift
echo '{'
echo '   global:'
printf '      %s;\n' $names "$@"
echo '   local: *;'
echo '};'
