#!/usr/bin/env bash
# Called by conda-build: SUNDIALS with its Fortran modules as static libraries, then the program.
set -euo pipefail

cmake -S sundials -B sundials-build -G Ninja ${CMAKE_ARGS-} \
   -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS="$CFLAGS -fcommon" \
   -DCMAKE_POSITION_INDEPENDENT_CODE=ON -DBUILD_SHARED_LIBS=OFF \
   -DBUILD_FORTRAN_MODULE_INTERFACE=ON -DENABLE_KLU=ON \
   -DKLU_INCLUDE_DIR="$PREFIX/include/suitesparse" -DKLU_LIBRARY_DIR="$PREFIX/lib" \
   -DBUILD_CVODES=OFF -DBUILD_IDA=OFF -DBUILD_IDAS=OFF -DBUILD_KINSOL=OFF \
   -DEXAMPLES_ENABLE_C=OFF -DEXAMPLES_ENABLE_F2003=OFF -DEXAMPLES_INSTALL=OFF \
   -DCMAKE_INSTALL_PREFIX="$PWD/sundials-prefix" -DCMAKE_INSTALL_LIBDIR=lib
ninja -C sundials-build install

export LDFLAGS="$LDFLAGS -lklu -lamd -lcolamd -lbtf -lsuitesparseconfig"
meson setup build contensou --prefix="$PREFIX" --libdir=lib --buildtype=release \
   -Dsundials_prefix="$PWD/sundials-prefix" -Dstatic_hdf5=disabled -Dtests=false
meson install -C build
