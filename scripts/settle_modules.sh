#!/bin/sh
# gfortran leaves a module file alone that would not change. Ninja sees that it is older than its
# source and would compile it, and all that use it, each time anew: give it the time of its object.
#
#   settle_modules.sh STAMP FOLDER...
set -eu

stamp=$1
shift
for folder; do
   for module in "$folder"/*.mod; do
      name=${module##*/}
      name=${name%.mod}
      for object in "${name#contensou_}" "${name#contensou_drivers_}" "unit_$name" \
         "unit_${name#test_}" "meson-generated_.._${name##*_tangential_}"; do
         object=$folder/$object.f90.o
         [ "$object" -nt "$module" ] && touch -r "$object" -- "$module"
      done
   done
done
touch -- "$stamp"
