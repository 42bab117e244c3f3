/*
 * What the writing of HDF5 files (hdf5_writer.c) and their reading (hdf5_reader.c) share. These
 * files alone name HDF5; the Fortran side is hdf5_file.f90 and hdf5_reader.f90, where the functions
 * are documented.
 *
 * The C interface is used because variable-length UTF-8 strings and dimension scales are out of
 * reach, or nearly so, of HDF5's Fortran interface.
 *
 * Functions returning int return 0 on success and 1 on failure; contensou_hdf5_message() then
 * tells the reason. HDF5 is not thread-safe and neither is this.
 */
#ifndef CONTENSOU_HDF5_COMMON_H
#define CONTENSOU_HDF5_COMMON_H

#define _GNU_SOURCE

#include <errno.h>
#include <hdf5.h>
#include <hdf5_hl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* The reason of the last failure. */
extern char contensou_hdf5_reason[2048];

/* Why a file that is locked is not opened. */
extern const char contensou_hdf5_in_use[];

/* Compose that reason, "cannot VERB PATH, object OBJECT: ...", from HDF5's error stack; the
   system's error number, if any. To be called before anything else of HDF5 is, since each call of
   HDF5 begins by emptying that stack. */
int contensou_hdf5_explain(const char *verb, const char *path, const char *object);

/* Compose it from the words given. */
int contensou_hdf5_refuse(const char *verb, const char *path, const char *object,
   const char *reason);

/* Start HDF5, silent and without its own clean-up at exit: that would try again to write what a
   full disk has refused, and is known to hang or crash over it. */
void contensou_hdf5_start(void);

/* Type of a variable-length UTF-8 string, in the file as in memory; nobody closes it. */
hid_t contensou_hdf5_text_type(void);

/* Properties for access to a file: no other program may write it when it is read. */
hid_t contensou_hdf5_access(int locking);

/* Put the seal behind the end of a complete file, which is open; 0 or errno. */
int contensou_hdf5_seal(int fd, const char *path);

/* What the seal of a file says: there is none, as in files of earlier versions, in incomplete ones
   and in those that other programs have changed; the file is as it was written; or it is damaged. */
enum { SEAL_NONE = 0, SEAL_GOOD = 1, SEAL_BROKEN = 2 };
int contensou_hdf5_check_seal(const char *path);

const char *contensou_hdf5_message(void);
const char *contensou_hdf5_version(void);

#endif
