/*
 * Writing of HDF5 files in the manner of netCDF-4, and reading of any: the one place that names
 * HDF5. The Fortran side is hdf5_file.f90 for writing and hdf5_reader.f90 for reading, where the
 * functions are documented.
 *
 * The C interface is used because variable-length UTF-8 strings and dimension scales are out of
 * reach, or nearly so, of HDF5's Fortran interface.
 *
 * Functions returning int return 0 on success and 1 on failure; contensou_hdf5_message() then
 * tells the reason. HDF5 is not thread-safe and neither is this.
 */
#define _GNU_SOURCE

#include <errno.h>
#include <fcntl.h>
#include <fenv.h>
#include <hdf5.h>
#include <hdf5_hl.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

enum { KIND_REAL = 1, KIND_INTEGER = 2, KIND_TEXT = 3, KIND_LONG = 4, KIND_BYTE = 5 };

/* Extents of the largest data set, and the largest chunk in bytes. */
enum { MAX_RANK = 8, MAX_CHUNK = 4 * 1024 * 1024 };

/* Bytes of the buffer in which texts become what the file holds, many at a time. */
enum { CONVERSION_BUFFER = 16 * 1024 };

struct series;

struct file {
   hid_t id;
   int descriptor;
   /* Bytes of the file that are known to have their place on the disk. */
   hsize_t reserved;
   int failed;
   /* Descriptor that holds the lock. */
   int lock;
   char *path;
   struct series *series;
};

/* A data set that grows along its first dimension. */
struct series {
   struct file *file;
   struct series *next;
   hid_t id;
   int kind;
   int rank;
   hsize_t extents[MAX_RANK];
};

struct file *contensou_hdf5_create(const char *path);
int contensou_hdf5_flush(struct file *file);
int contensou_hdf5_sync(struct file *file);
int contensou_hdf5_bound_memory(struct file *file);
int contensou_hdf5_close(struct file *file);
int contensou_hdf5_close_as(struct file *file, const char *name, int replace);
int contensou_system_rename(const char *from, const char *to, int replace);
void contensou_hdf5_abandon(struct file *file);
int contensou_hdf5_create_group(struct file *file, const char *path);
int contensou_hdf5_put_attribute(struct file *file, const char *object, const char *name, int kind,
   int rank, int64_t count, const void *data, const char *text, size_t length);
int contensou_hdf5_put_dataset(struct file *file, const char *path, int kind, int rank,
   const int64_t *extents, const void *data, const char *text, size_t length, int scale_count,
   const char *scales, size_t scale_length, int is_scale, const char *units,
   const char *long_name);
struct series *contensou_hdf5_create_series(struct file *file, const char *path, int kind, int rank,
   const int64_t *extents, int64_t chunk_rows, int compress, int scale_count, const char *scales,
   size_t scale_length, int is_scale, const char *units, const char *long_name);
int contensou_hdf5_append(struct series *series, int64_t rows, const void *data, const char *text,
   size_t length);
int contensou_hdf5_read_status(const char *path, char *status, size_t size);
struct reader;
struct item;
struct names;
struct reader *contensou_hdf5_open_reader(const char *path);
void contensou_hdf5_close_reader(struct reader *reader);
struct names *contensou_hdf5_list(struct reader *reader, const char *object, int attributes);
int contensou_hdf5_listed_count(const struct names *names);
const char *contensou_hdf5_listed(const struct names *names, int i, int *link);
void contensou_hdf5_free_list(struct names *names);
int contensou_hdf5_object(struct reader *reader, const char *path, int64_t *address);
const char *contensou_hdf5_link_value(struct reader *reader, const char *path);
struct item *contensou_hdf5_open_item(struct reader *reader, const char *object,
   const char *attribute);
struct item *contensou_hdf5_open_scale(struct item *item, int dimension);
const char *contensou_hdf5_dimension_name(struct item *item, int dimension);
void contensou_hdf5_close_item(struct item *item);
int contensou_hdf5_describe(const struct item *item, int64_t *size, int *rank, int64_t *extents,
   int64_t *chunk, int *is_null);
const char *contensou_hdf5_type_text(const struct item *item);
int contensou_hdf5_same_type(const struct item *a, const struct item *b);
int contensou_hdf5_read(struct item *item, const int64_t *start, const int64_t *count, int as_real,
   void *buffer);
int contensou_hdf5_read_texts(struct item *item, const int64_t *start, const int64_t *count);
const char *contensou_hdf5_text(const struct item *item, int64_t i);
const char *contensou_hdf5_item_name(const struct item *item);
const char *contensou_hdf5_units(struct item *item);
const char *contensou_hdf5_message(void);
const char *contensou_hdf5_version(void);

/* src/base/guard.c */
void contensou_guard_enter(const char *path, const char *object);
void contensou_guard_leave(void);

static char last_message[2048];

/* ---- Errors ---------------------------------------------------------------------------------- */

/* What HDF5's error stack says: the system's error number, if any, and the innermost message. */
struct cause {
   int code;
   char text[512];
};

static herr_t inspect(unsigned position, const H5E_error2_t *entry, void *data)
{
   struct cause *cause = data;
   const char *text = entry->desc ? entry->desc : "";
   const char *number = strstr(text, "errno = ");
   if (position == 0) snprintf(cause->text, sizeof cause->text, "%s", text);
   if (number && cause->code == 0) cause->code = atoi(number + strlen("errno = "));
   return 0;
}

/* Compose the message from HDF5's error stack; the system's error number, if any. To be called before anything else of HDF5 is, since
   each call of HDF5 begins by emptying that stack. */
static int explain(const char *verb, const char *path, const char *object)
{
   struct cause cause = {0, ""};
   H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, inspect, &cause);
   if (cause.code == EAGAIN || cause.code == EWOULDBLOCK) {
      snprintf(last_message, sizeof last_message,
         "cannot %s %s: another program has it open", verb, path);
   } else if (cause.code != 0) {
      snprintf(last_message, sizeof last_message, "cannot %s %s: %s", verb, path,
         strerror(cause.code));
   } else {
      snprintf(last_message, sizeof last_message, "cannot %s %s%s%s: HDF5 says \"%s\"", verb, path,
         object ? ", object " : "", object ? object : "",
         cause.text[0] ? cause.text : "no reason given");
   }
   return cause.code;
}

/* Note a failed write; the file then takes nothing but its release. */
static int fail(struct file *file, const char *object)
{
   if (!file->failed) explain("write", file->path, object);
   file->failed = 1;
   return 1;
}

/* Note a failure that is not HDF5's. */
static int fail_because(struct file *file, const char *object, const char *reason)
{
   if (!file->failed) {
      snprintf(last_message, sizeof last_message, "cannot write %s%s%s: %s", file->path,
         object ? ", object " : "", object ? object : "", reason);
   }
   file->failed = 1;
   return 1;
}

/* ---- Text ------------------------------------------------------------------------------------ */

/* A Fortran array of texts of equal length as C strings without the trailing blanks. */
struct texts {
   char **item;
   char *bytes;
};

static void free_texts(struct texts *texts)
{
   free(texts->item);
   free(texts->bytes);
   texts->item = NULL;
   texts->bytes = NULL;
}

static int make_texts(struct texts *texts, const char *text, size_t length, size_t count, int trim)
{
   texts->item = malloc((count + 1) * sizeof *texts->item);
   texts->bytes = malloc(count * (length + 1) + 1);
   if (!texts->item || !texts->bytes) {
      free_texts(texts);
      return 1;
   }
   char *to = texts->bytes;
   for (size_t i = 0; i < count; ++i) {
      const char *from = text + i * length;
      size_t used = length;
      while (trim && used > 0 && from[used - 1] == ' ') --used;
      memcpy(to, from, used);
      to[used] = '\0';
      texts->item[i] = to;
      to += used + 1;
   }
   return 0;
}

/* ---- What objects have in common ------------------------------------------------------------- */

/* Types, properties and the space of a single value. Except where a caller is said to, nobody
   closes them: to make them anew for each object took a tenth of the time of a small file. */

/* Type of a variable-length UTF-8 string, in the file as in memory. */
static hid_t text_type(void)
{
   static hid_t kept = H5I_INVALID_HID;
   if (kept >= 0) return kept;
   hid_t type = H5Tcopy(H5T_C_S1);
   if (type >= 0
      && (H5Tset_size(type, H5T_VARIABLE) < 0 || H5Tset_cset(type, H5T_CSET_UTF8) < 0)) {
      H5Tclose(type);
      type = H5I_INVALID_HID;
   }
   return kept = type;
}

static hid_t file_type(int kind)
{
   if (kind == KIND_REAL) return H5T_IEEE_F64LE;
   if (kind == KIND_INTEGER) return H5T_STD_I32LE;
   if (kind == KIND_LONG) return H5T_STD_I64LE;
   if (kind == KIND_BYTE) return H5T_STD_I8LE;
   return text_type();
}

static hid_t memory_type(int kind)
{
   if (kind == KIND_REAL) return H5T_NATIVE_DOUBLE;
   if (kind == KIND_INTEGER) return H5T_NATIVE_INT32;
   if (kind == KIND_LONG) return H5T_NATIVE_INT64;
   if (kind == KIND_BYTE) return H5T_NATIVE_INT8;
   return text_type();
}

static hid_t single_space(void)
{
   static hid_t kept = H5I_INVALID_HID;
   if (kept < 0) kept = H5Screate(H5S_SCALAR);
   return kept;
}

/* Properties for creating an object: order of attributes kept, no times, so that equal content
   gives equal files. The caller closes them. */
static hid_t creation_list(hid_t class)
{
   const unsigned order = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;
   hid_t list = H5Pcreate(class);
   if (list < 0) return list;
   if (H5Pset_attr_creation_order(list, order) < 0 || H5Pset_obj_track_times(list, 0) < 0
      || (class == H5P_GROUP_CREATE && H5Pset_link_creation_order(list, order) < 0)) {
      H5Pclose(list);
      return H5I_INVALID_HID;
   }
   return list;
}

/* Properties for creating a data set that is written once. */
static hid_t dataset_list(void)
{
   static hid_t kept = H5I_INVALID_HID;
   if (kept < 0) kept = creation_list(H5P_DATASET_CREATE);
   return kept;
}

/* Properties for naming something: a link or an attribute, as the class says. */
static hid_t naming_list(hid_t class)
{
   hid_t list = H5Pcreate(class);
   if (list >= 0 && H5Pset_char_encoding(list, H5T_CSET_UTF8) < 0) {
      H5Pclose(list);
      list = H5I_INVALID_HID;
   }
   return list;
}

static hid_t link_list(void)
{
   static hid_t kept = H5I_INVALID_HID;
   if (kept < 0) kept = naming_list(H5P_LINK_CREATE);
   return kept;
}

static hid_t attribute_list(void)
{
   static hid_t kept = H5I_INVALID_HID;
   if (kept < 0) kept = naming_list(H5P_ATTRIBUTE_CREATE);
   return kept;
}

/* Properties for writing. HDF5 clears a buffer for texts at each call, of 1 MiB unless told
   otherwise, which took longer than all the rest of a small file. */
static hid_t transfer_list(void)
{
   static hid_t kept = H5I_INVALID_HID;
   if (kept < 0) {
      kept = H5Pcreate(H5P_DATASET_XFER);
      if (kept < 0 || H5Pset_buffer(kept, CONVERSION_BUFFER, NULL, NULL) < 0) return H5P_DEFAULT;
   }
   return kept;
}

/* ---- Files ----------------------------------------------------------------------------------- */

/* Keep changed metadata in memory between flushes, so that a process killed at any moment between
   two of them leaves the state of the last one. It costs about 100 bytes for each chunk. */
static herr_t hold_metadata(hid_t access)
{
   H5AC_cache_config_t config;
   config.version = H5AC__CURR_CACHE_CONFIG_VERSION;
   if (H5Pget_mdc_config(access, &config) < 0) return -1;
   config.evictions_enabled = 0;
   config.incr_mode = H5C_incr__off;
   config.flash_incr_mode = H5C_flash_incr__off;
   config.decr_mode = H5C_decr__off;
   return H5Pset_mdc_config(access, &config);
}

/* Properties for access to a file: a format that HDF5 1.8 reads, which has no mark "open for
   writing" either that would make a killed run's file unreadable; locks where there are any. */
static hid_t access_list(int locking)
{
   hid_t access = H5Pcreate(H5P_FILE_ACCESS);
   if (access < 0) return access;
   if (H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18) < 0
      || H5Pset_fclose_degree(access, H5F_CLOSE_STRONG) < 0
#if H5_VERSION_GE(1, 12, 1) || (H5_VERS_MINOR == 10 && H5_VERS_RELEASE >= 7)
      || H5Pset_file_locking(access, locking, 1) < 0
#endif
      || hold_metadata(access) < 0) {
      H5Pclose(access);
      return H5I_INVALID_HID;
   }
   return access;
}

/* Start HDF5, silent and without its own clean-up at exit: that would try again to write what a
   full disk has refused, and is known to hang or crash over it. */
static void start_library(void)
{
   static int started = 0;
   if (!started) H5dont_atexit();
   started = 1;
   H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
}

static void release(struct file *file)
{
   if (file->lock >= 0) close(file->lock);
   while (file->series) {
      struct series *next = file->series->next;
      free(file->series);
      file->series = next;
   }
   free(file->path);
   free(file);
}

/* Take the lock that tells other programs that a file is being written; the descriptor, or -1 when
   another program has it. HDF5 itself would empty the file first and ask for its lock afterwards. */
static int take_lock(const char *path)
{
   struct stat mine, now;
   int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
   if (fd < 0) return -1;
   if (flock(fd, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) {
      /* Its owner may have given the file its final name in between. */
      if (fstat(fd, &mine) == 0 && stat(path, &now) == 0 && mine.st_ino == now.st_ino
         && mine.st_dev == now.st_dev) return fd;
      errno = EWOULDBLOCK;
   }
   int code = errno;
   close(fd);
   errno = code;
   return -1;
}

/* Remove a file that could not be filled and is of no use; a device is left where it is. */
static void discard(const struct file *file)
{
   struct stat info;
   if (fstat(file->lock, &info) == 0 && S_ISREG(info.st_mode)) unlink(file->path);
}

struct file *contensou_hdf5_create(const char *path)
{
   const unsigned order = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;
   start_library();
   struct file *file = calloc(1, sizeof *file);
   if (file) file->path = strdup(path);
   if (!file || !file->path) {
      free(file);
      snprintf(last_message, sizeof last_message, "cannot create %s: %s", path, strerror(ENOMEM));
      return NULL;
   }
   file->lock = take_lock(path);
   if (file->lock < 0) {
      snprintf(last_message, sizeof last_message, "cannot create %s: %s", path,
         errno == EWOULDBLOCK ? "another program has it open" : strerror(errno));
      release(file);
      return NULL;
   }
   hid_t access = access_list(0);
   hid_t creation = H5Pcreate(H5P_FILE_CREATE);
   file->id = H5I_INVALID_HID;
   if (access >= 0 && creation >= 0 && H5Pset_link_creation_order(creation, order) >= 0
      && H5Pset_attr_creation_order(creation, order) >= 0
      && H5Pset_obj_track_times(creation, 0) >= 0) {
      file->id = H5Fcreate(path, H5F_ACC_TRUNC, creation, access);
   }
   int code = file->id < 0 ? explain("create", path, NULL) : 0;
   if (code != 0) discard(file);
   if (access >= 0) H5Pclose(access);
   if (creation >= 0) H5Pclose(creation);
   if (file->id < 0) {
      release(file);
      return NULL;
   }
   void *handle = NULL;
   file->descriptor = -1;
   if (H5Fget_vfd_handle(file->id, H5P_DEFAULT, &handle) >= 0 && handle) {
      file->descriptor = *(int *)handle;
   }
   /* From here on the file can be opened, whatever happens to this process. */
   if (contensou_hdf5_flush(file)) {
      discard(file);
      contensou_hdf5_abandon(file);
      return NULL;
   }
   return file;
}

/* Claim the disk space that a flush will need, so that it is refused here, before any metadata has
   been written, and a full disk leaves the file as it was last flushed. */
static int reserve(struct file *file)
{
   hsize_t size = 0;
   int code = 0;
   if (file->descriptor < 0) return 0;
   if (H5Fget_filesize(file->id, &size) < 0) return fail(file, NULL);
   if (size <= file->reserved) return 0;
#ifdef __linux__
   do {
      code = fallocate(file->descriptor, 0, (off_t)file->reserved, (off_t)(size - file->reserved))
         == 0 ? 0 : errno;
   } while (code == EINTR);
#endif
   if (code == ENOSPC || code == EDQUOT || code == EFBIG || code == EIO) {
      return fail_because(file, NULL, strerror(code));
   }
   /* A file system that cannot reserve space finds out while writing. */
   file->reserved = size;
   return 0;
}

int contensou_hdf5_bound_memory(struct file *file)
{
   if (file->failed) return 1;
   H5AC_cache_config_t config;
   config.version = H5AC__CURR_CACHE_CONFIG_VERSION;
   if (H5Fget_mdc_config(file->id, &config) < 0) return fail(file, file->path);
   config.evictions_enabled = 1;
   if (H5Fset_mdc_config(file->id, &config) < 0) return fail(file, file->path);
   return 0;
}

int contensou_hdf5_flush(struct file *file)
{
   if (file->failed || reserve(file)) return 1;
   if (H5Fflush(file->id, H5F_SCOPE_LOCAL) < 0) return fail(file, NULL);
   return 0;
}

/* Bring what was flushed to the disk, for the case that the power fails. */
int contensou_hdf5_sync(struct file *file)
{
   if (file->failed) return 1;
   if (file->descriptor >= 0 && fsync(file->descriptor) != 0 && errno != EINVAL
      && errno != ENOTSUP) return fail_because(file, NULL, strerror(errno));
   return 0;
}

int contensou_hdf5_close(struct file *file)
{
   return contensou_hdf5_close_as(file, NULL, 0);
}

int contensou_hdf5_close_as(struct file *file, const char *name, int replace)
{
   /* Flushing first leaves nothing that could fail to the closing itself, after which the file
      could no longer be abandoned. */
   if (contensou_hdf5_flush(file)) {
      contensou_hdf5_abandon(file);
      return 1;
   }
   for (struct series *series = file->series; series; series = series->next) H5Dclose(series->id);
   int failed = H5Fclose(file->id) < 0;
   if (failed) explain("close", file->path, NULL);
   if (!failed && name) {
      int code = contensou_system_rename(file->path, name, replace);
      if (code) {
         snprintf(last_message, sizeof last_message, "cannot rename %s to %s: %s", file->path, name,
            strerror(code));
         failed = 1;
      }
   }
   release(file);
   return failed;
}

void contensou_hdf5_abandon(struct file *file)
{
   /* HDF5 cannot drop what it failed to write: let it write into the void, so that closing
      succeeds, memory is freed, and the file on the disk stays as it was last flushed. */
   if (file->descriptor >= 0) {
      int nowhere = open("/dev/null", O_RDWR);
      if (nowhere >= 0) {
         dup2(nowhere, file->descriptor);
         close(nowhere);
      }
   }
   for (struct series *series = file->series; series; series = series->next) H5Dclose(series->id);
   H5Fclose(file->id);
   release(file);
}

/* ---- Groups and attributes ------------------------------------------------------------------- */

int contensou_hdf5_create_group(struct file *file, const char *path)
{
   if (file->failed) return 1;
   int failed = 0;
   hid_t links = link_list();
   hid_t creation = creation_list(H5P_GROUP_CREATE);
   hid_t group = H5I_INVALID_HID;
   if (links >= 0 && creation >= 0) {
      group = H5Gcreate2(file->id, path, links, creation, H5P_DEFAULT);
   }
   if (group < 0 || H5Gclose(group) < 0) failed = fail(file, path);
   if (creation >= 0) H5Pclose(creation);
   return failed;
}

/* 1 if the attribute can take a value of this type and shape. */
static int attribute_fits(hid_t attribute, hid_t type, hid_t space)
{
   hid_t present_type = H5Aget_type(attribute);
   hid_t present_space = H5Aget_space(attribute);
   int fits = present_type >= 0 && present_space >= 0 && H5Tequal(present_type, type) > 0
      && H5Sextent_equal(present_space, space) > 0;
   if (present_type >= 0) H5Tclose(present_type);
   if (present_space >= 0) H5Sclose(present_space);
   return fits;
}

static hid_t create_attribute(hid_t object, const char *name, hid_t type, hid_t space)
{
   hid_t creation = attribute_list();
   if (creation < 0) return creation;
   return H5Acreate2(object, name, type, space, creation, H5P_DEFAULT);
}

/* Open an attribute that fits, else create it in place of what there is. */
static hid_t provide_attribute(hid_t object, const char *name, hid_t type, hid_t space)
{
   htri_t exists = H5Aexists(object, name);
   if (exists < 0) return H5I_INVALID_HID;
   if (exists) {
      hid_t attribute = H5Aopen(object, name, H5P_DEFAULT);
      if (attribute < 0 || attribute_fits(attribute, type, space)) return attribute;
      H5Aclose(attribute);
      if (H5Adelete(object, name) < 0) return H5I_INVALID_HID;
   }
   return create_attribute(object, name, type, space);
}

/* Write an attribute of an open object, which has none of this name yet if it is new; data are as
   HDF5 takes them. */
static int write_attribute(struct file *file, hid_t object, int is_new, const char *name, int kind,
   int rank, hsize_t count, const void *data)
{
   int failed = 0;
   hid_t stored = file_type(kind);
   hid_t memory = memory_type(kind);
   hid_t space = rank == 0 ? single_space() : H5Screate_simple(1, &count, NULL);
   hid_t attribute = H5I_INVALID_HID;
   if (stored >= 0 && memory >= 0 && space >= 0) {
      attribute = is_new ? create_attribute(object, name, stored, space)
                         : provide_attribute(object, name, stored, space);
   }
   if (attribute < 0 || ((rank == 0 || count > 0) && H5Awrite(attribute, memory, data) < 0)) {
      failed = fail(file, name);
   }
   if (attribute >= 0) H5Aclose(attribute);
   if (rank > 0 && space >= 0) H5Sclose(space);
   return failed;
}

int contensou_hdf5_put_attribute(struct file *file, const char *object, const char *name, int kind,
   int rank, int64_t count, const void *data, const char *text, size_t length)
{
   if (file->failed) return 1;
   int failed = 0;
   struct texts texts = {NULL, NULL};
   hid_t target = H5Oopen(file->id, object, H5P_DEFAULT);
   if (target < 0) {
      failed = fail(file, object);
   } else if (kind == KIND_TEXT && make_texts(&texts, text, length, (size_t)count, 1)) {
      failed = fail_because(file, object, strerror(ENOMEM));
   } else {
      failed = write_attribute(file, target, 0, name, kind, rank, (hsize_t)count,
         kind == KIND_TEXT ? (const void *)texts.item : data);
   }
   free_texts(&texts);
   if (target >= 0) H5Oclose(target);
   return failed;
}

/* Write the attributes that every data set has, to a new one. */
static int describe(struct file *file, hid_t dataset, const char *units, const char *long_name)
{
   if (units[0] != '\0' && write_attribute(file, dataset, 1, "units", KIND_TEXT, 0, 1, &units)) {
      return 1;
   }
   return write_attribute(file, dataset, 1, "long_name", KIND_TEXT, 0, 1, &long_name);
}

/* ---- Data sets ------------------------------------------------------------------------------- */

/* Give a data set its dimension scales, outermost first, or make it one. */
static int set_dimensions(struct file *file, hid_t dataset, const char *path, int count,
   const char *scales, size_t length, int is_scale)
{
   int failed = 0;
   struct texts names;
   if (is_scale) {
      const char *slash = strrchr(path, '/');
      if (H5DSset_scale(dataset, slash ? slash + 1 : path) < 0) return fail(file, path);
   }
   if (make_texts(&names, scales, length, (size_t)count, 1)) {
      return fail_because(file, path, strerror(ENOMEM));
   }
   for (int i = 0; i < count && !failed; ++i) {
      hid_t scale = H5Dopen2(file->id, names.item[i], H5P_DEFAULT);
      if (scale < 0) {
         failed = fail(file, names.item[i]);
      } else {
         if (H5DSattach_scale(dataset, scale, (unsigned)i) < 0) failed = fail(file, path);
         H5Dclose(scale);
      }
   }
   free_texts(&names);
   return failed;
}

/* Create a data set with its attributes and scales; an invalid identifier on failure. */
static hid_t create_dataset(struct file *file, const char *path, int kind, hid_t space,
   hid_t creation, hid_t access, int scale_count, const char *scales, size_t scale_length,
   int is_scale, const char *units, const char *long_name)
{
   hid_t links = link_list();
   hid_t type = file_type(kind);
   hid_t dataset = H5I_INVALID_HID;
   if (links >= 0 && type >= 0 && space >= 0 && creation >= 0 && access >= 0) {
      dataset = H5Dcreate2(file->id, path, type, space, links, creation, access);
   }
   if (dataset < 0) {
      fail(file, path);
   } else if (describe(file, dataset, units, long_name)
      || set_dimensions(file, dataset, path, scale_count, scales, scale_length, is_scale)) {
      H5Dclose(dataset);
      dataset = H5I_INVALID_HID;
   }
   return dataset;
}

int contensou_hdf5_put_dataset(struct file *file, const char *path, int kind, int rank,
   const int64_t *extents, const void *data, const char *text, size_t length, int scale_count,
   const char *scales, size_t scale_length, int is_scale, const char *units, const char *long_name)
{
   if (file->failed) return 1;
   if (rank > MAX_RANK) return fail_because(file, path, "too many dimensions");
   if (scale_count != (is_scale ? 0 : rank)) {
      return fail_because(file, path, "the number of scales is not that of dimensions");
   }
   hsize_t size[MAX_RANK];
   size_t values = 1;
   for (int i = 0; i < rank; ++i) {
      size[i] = (hsize_t)extents[i];
      values *= (size_t)extents[i];
   }
   struct texts texts = {NULL, NULL};
   /* A single text is content and stays as it is; blanks fill up the items of an array. */
   if (kind == KIND_TEXT && make_texts(&texts, text, length, values, rank > 0)) {
      return fail_because(file, path, strerror(ENOMEM));
   }
   int failed = 0;
   hid_t memory = memory_type(kind);
   hid_t space = rank == 0 ? single_space() : H5Screate_simple(rank, size, NULL);
   hid_t dataset = create_dataset(file, path, kind, space, dataset_list(), H5P_DEFAULT, scale_count,
      scales, scale_length, is_scale, units, long_name);
   if (dataset < 0) {
      failed = 1;
   } else if (values > 0
      && (memory < 0
         || H5Dwrite(dataset, memory, H5S_ALL, H5S_ALL, transfer_list(),
               kind == KIND_TEXT ? (const void *)texts.item : data) < 0)) {
      failed = fail(file, path);
   }
   if (dataset >= 0) H5Dclose(dataset);
   if (rank > 0 && space >= 0) H5Sclose(space);
   free_texts(&texts);
   return failed;
}

/* ---- Series ---------------------------------------------------------------------------------- */

/* Values in one row. */
static size_t row_values(const struct series *series)
{
   size_t values = 1;
   for (int i = 1; i < series->rank; ++i) values *= (size_t)series->extents[i];
   return values;
}

/* Bytes of one row in the file. */
static size_t row_size(const struct series *series)
{
   size_t size = series->kind == KIND_TEXT ? 16
      : series->kind == KIND_INTEGER       ? 4
      : series->kind == KIND_BYTE          ? 1
                                           : 8;
   return size * row_values(series);
}

/* Set chunks of that many rows, fewer if the rows are long. Without a cache rows go straight to
   their place on the disk: a full disk is noticed by the append that meets it, while the metadata
   still speak of the rows before. */
static herr_t set_chunks(const struct series *series, hid_t creation, hid_t access, hsize_t rows,
   int compress)
{
   hsize_t chunk[MAX_RANK];
   size_t row = row_size(series);
   if (row > 0 && rows > MAX_CHUNK / row) rows = MAX_CHUNK / row;
   chunk[0] = rows > 0 ? rows : 1;
   for (int i = 1; i < series->rank; ++i) chunk[i] = series->extents[i] ? series->extents[i] : 1;
   if (H5Pset_chunk(creation, series->rank, chunk) < 0) return -1;
   /* Where the library comes without compression, the file is larger. */
   compress = compress && H5Zfilter_avail(H5Z_FILTER_DEFLATE) > 0;
   if (compress && (H5Pset_shuffle(creation) < 0 || H5Pset_deflate(creation, 1) < 0)) return -1;
   /* What lies behind the last row need not be filled, except for texts, which are addresses, and
      in what is compressed, which would not be the same twice. */
   if (series->kind != KIND_TEXT && !compress && H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER) < 0) return -1;
   return H5Pset_chunk_cache(access, 0, 0, 0.0);
}

struct series *contensou_hdf5_create_series(struct file *file, const char *path, int kind, int rank,
   const int64_t *extents, int64_t chunk_rows, int compress, int scale_count, const char *scales,
   size_t scale_length, int is_scale, const char *units, const char *long_name)
{
   hsize_t most[MAX_RANK];
   if (file->failed) return NULL;
   struct series *series = calloc(1, sizeof *series);
   if (!series) {
      fail_because(file, path, strerror(ENOMEM));
      return NULL;
   }
   series->file = file;
   series->kind = kind;
   series->rank = rank + 1;
   series->id = H5I_INVALID_HID;
   if (series->rank > MAX_RANK) {
      fail_because(file, path, "too many dimensions");
   } else if (scale_count != (is_scale ? rank : rank + 1) || (is_scale && rank > 0)) {
      fail_because(file, path, "the number of scales is not that of dimensions");
   } else {
      most[0] = H5S_UNLIMITED;
      for (int i = 0; i < rank; ++i) most[i + 1] = series->extents[i + 1] = (hsize_t)extents[i];
      hid_t space = H5Screate_simple(series->rank, series->extents, most);
      hid_t creation = creation_list(H5P_DATASET_CREATE);
      hid_t access = H5Pcreate(H5P_DATASET_ACCESS);
      if (creation >= 0 && access >= 0
         && set_chunks(series, creation, access, chunk_rows > 0 ? (hsize_t)chunk_rows : 1, compress)
            < 0) {
         fail(file, path);
      } else {
         series->id = create_dataset(file, path, kind, space, creation, access, scale_count, scales,
            scale_length, is_scale, units, long_name);
      }
      if (access >= 0) H5Pclose(access);
      if (creation >= 0) H5Pclose(creation);
      if (space >= 0) H5Sclose(space);
   }
   if (series->id < 0) {
      free(series);
      return NULL;
   }
   series->next = file->series;
   file->series = series;
   return series;
}

/* Write rows behind those that the data set has. */
static int write_rows(struct series *series, hsize_t rows, const void *data)
{
   hsize_t start[MAX_RANK] = {0};
   hsize_t count[MAX_RANK];
   memcpy(count, series->extents, sizeof count);
   start[0] = series->extents[0];
   count[0] = rows;
   series->extents[0] += rows;
   if (H5Dset_extent(series->id, series->extents) < 0) return fail(series->file, NULL);
   if (row_values(series) == 0) return 0;
   hid_t type = memory_type(series->kind);
   hid_t stored = H5Dget_space(series->id);
   hid_t memory = H5Screate_simple(series->rank, count, NULL);
   int failed = type < 0 || stored < 0 || memory < 0
      || H5Sselect_hyperslab(stored, H5S_SELECT_SET, start, NULL, count, NULL) < 0
      || H5Dwrite(series->id, type, memory, stored, transfer_list(), data) < 0;
   if (failed) fail(series->file, NULL);
   if (memory >= 0) H5Sclose(memory);
   if (stored >= 0) H5Sclose(stored);
   return failed;
}

int contensou_hdf5_append(struct series *series, int64_t rows, const void *data, const char *text,
   size_t length)
{
   struct texts texts = {NULL, NULL};
   if (series->file->failed) return 1;
   if (rows <= 0) return 0;
   if (series->kind == KIND_TEXT) {
      if (make_texts(&texts, text, length, (size_t)rows * row_values(series), 1)) {
         return fail_because(series->file, "a series of texts", strerror(ENOMEM));
      }
      /* An empty text is a null address, which takes no place elsewhere in the file. */
      for (size_t i = 0; i < (size_t)rows * row_values(series); ++i) {
         if (texts.item[i][0] == '\0') texts.item[i] = NULL;
      }
      data = texts.item;
   }
   int failed = write_rows(series, (hsize_t)rows, data);
   free_texts(&texts);
   return failed;
}

/* ---- Reading --------------------------------------------------------------------------------- */

/* Read the text attribute `status` of an open file. */
static int read_status(hid_t file, const char *path, char *status, size_t size)
{
   int failed = 1;
   char *text = NULL;
   hid_t type = text_type();
   hid_t attribute = H5Aopen(file, "status", H5P_DEFAULT);
   if (type >= 0 && attribute >= 0 && H5Aread(attribute, type, &text) >= 0) {
      snprintf(status, size, "%s", text ? text : "");
      H5free_memory(text);
      failed = 0;
   }
   if (failed) explain("read the status of", path, NULL);
   if (attribute >= 0) H5Aclose(attribute);
   return failed;
}

int contensou_hdf5_read_status(const char *path, char *status, size_t size)
{
   start_library();
   hid_t access = access_list(1);
   hid_t file = access < 0 ? H5I_INVALID_HID : H5Fopen(path, H5F_ACC_RDONLY, access);
   int failed = file < 0;
   if (failed) explain("read", path, NULL);
   if (!failed) failed = read_status(file, path, status, size);
   if (access >= 0) H5Pclose(access);
   if (file >= 0) H5Fclose(file);
   return failed;
}

/* ---- Reading of any file --------------------------------------------------------------------- */

/* Classes of values, and kinds of links and objects, as hdf5_reader.f90 knows them. */
enum {
   CLASS_REAL = 1, CLASS_INTEGER = 2, CLASS_UNSIGNED = 3, CLASS_TEXT = 4, CLASS_RAW = 5,
   CLASS_OTHER = 6
};
enum { LINK_HARD = 1, LINK_SOFT = 2, LINK_OTHER = 3 };
enum { OBJECT_GROUP = 1, OBJECT_DATASET = 2, OBJECT_TYPE = 3, OBJECT_OTHER = 4 };

/* Bounds that no sensible file comes near: links of one group, bytes of their names, bytes of one
   text or attribute, bytes of one compressed chunk. */
enum {
   MAX_LINKS = 200000, MAX_NAMES = 32 * 1024 * 1024, MAX_TEXT = 64 * 1024 * 1024,
   MAX_PACKED_CHUNK = 128 * 1024 * 1024
};

/* The best compression there is (deflate) gains a factor of 1032. */
static const double max_gain = 1100.0;
static const double free_bytes = 1024.0 * 1024.0 * 1024.0;

struct reader {
   hid_t id;
   char *path;
   /* Bytes of values that may still be read: a file can claim far more than it holds. */
   double budget;
};

/* Texts that HDF5 allocates while it reads. */
struct arena {
   size_t used;
   struct arena_block *blocks;
};

struct arena_block {
   struct arena_block *next;
   max_align_t bytes[];
};

/* A data set or an attribute. */
struct item {
   struct reader *reader;
   char *object;
   hid_t id;
   int is_attribute;
   hid_t type;
   int class;
   size_t size;
   int is_null;
   int is_variable;
   int rank;
   hsize_t extents[H5S_MAX_RANK];
   hsize_t chunk[H5S_MAX_RANK];
   char type_text[96];
   /* The texts that were read last. */
   struct arena arena;
   char *bytes;
   char **texts;
   size_t text_count;
};

/* A link of a group or an attribute of an object. */
struct named {
   char *name;
   int link;
};

struct names {
   int count;
   int room;
   struct named *entry;
   size_t bytes;
};

/* Keep the cache of metadata small: the maps of the chunks of a large file would fill it, and none
   of them is needed twice. */
static herr_t limit_metadata(hid_t access)
{
   H5AC_cache_config_t config;
   config.version = H5AC__CURR_CACHE_CONFIG_VERSION;
   if (H5Pget_mdc_config(access, &config) < 0) return -1;
   config.set_initial_size = 1;
   config.initial_size = 1024 * 1024;
   config.min_size = 512 * 1024;
   config.max_size = 2 * 1024 * 1024;
   config.flash_incr_mode = H5C_flash_incr__off;
   return H5Pset_mdc_config(access, &config);
}

/* Note a failure to read: HDF5's reason, or the one given. */
static int fail_read(const struct reader *reader, const char *object, const char *reason)
{
   if (reason) {
      snprintf(last_message, sizeof last_message, "cannot read %s%s%s: %s", reader->path,
         object && object[0] ? ", object " : "", object ? object : "", reason);
   } else {
      explain("read", reader->path, object && object[0] ? object : NULL);
   }
   return 1;
}

struct reader *contensou_hdf5_open_reader(const char *path)
{
   struct stat info;
   start_library();
   struct reader *reader = calloc(1, sizeof *reader);
   if (reader) reader->path = strdup(path);
   if (!reader || !reader->path) {
      free(reader);
      snprintf(last_message, sizeof last_message, "cannot read %s: %s", path, strerror(ENOMEM));
      return NULL;
   }
   reader->id = H5I_INVALID_HID;
   if (stat(path, &info) != 0) {
      fail_read(reader, NULL, errno == ENOENT ? "it does not exist" : strerror(errno));
   } else if (S_ISDIR(info.st_mode)) {
      fail_read(reader, NULL, "it is a folder");
   } else if (!S_ISREG(info.st_mode)) {
      fail_read(reader, NULL, "it is not a regular file");
   } else {
      reader->budget = free_bytes + max_gain * (double)info.st_size;
      contensou_guard_enter(path, "");
      hid_t access = H5Pcreate(H5P_FILE_ACCESS);
      if (access >= 0 && H5Pset_fclose_degree(access, H5F_CLOSE_STRONG) >= 0
#if H5_VERSION_GE(1, 12, 1) || (H5_VERS_MINOR == 10 && H5_VERS_RELEASE >= 7)
         && H5Pset_file_locking(access, 1, 1) >= 0
#endif
         && limit_metadata(access) >= 0) {
         reader->id = H5Fopen(path, H5F_ACC_RDONLY, access);
      }
      if (reader->id < 0) {
         htri_t known = 1;
         explain("read", path, NULL);
         H5E_BEGIN_TRY known = H5Fis_hdf5(path); H5E_END_TRY
         if (known == 0) fail_read(reader, NULL, "it is not an HDF5 file");
      }
      if (access >= 0) H5Pclose(access);
      contensou_guard_leave();
   }
   if (reader->id < 0) {
      free(reader->path);
      free(reader);
      return NULL;
   }
   return reader;
}

void contensou_hdf5_close_reader(struct reader *reader)
{
   contensou_guard_enter(reader->path, "");
   H5Fclose(reader->id);
   contensou_guard_leave();
   free(reader->path);
   free(reader);
}

/* Take bytes from the budget. */
static int spend(struct reader *reader, const char *object, double bytes)
{
   if (bytes > reader->budget) {
      return fail_read(reader, object, "it claims more values than a file of this size can hold");
   }
   reader->budget -= bytes;
   return 0;
}

/* ---- Reading: groups ---- */

void contensou_hdf5_free_list(struct names *names)
{
   for (int i = 0; i < names->count; ++i) free(names->entry[i].name);
   free(names->entry);
   free(names);
}

static herr_t add_name(struct names *names, const char *name, int link)
{
   size_t length = strlen(name) + 1;
   if (names->count == MAX_LINKS || names->bytes + length > MAX_NAMES) return -1;
   if (names->count == names->room) {
      int room = names->room ? 2 * names->room : 16;
      struct named *longer = realloc(names->entry, (size_t)room * sizeof *longer);
      if (!longer) return -1;
      names->entry = longer;
      names->room = room;
   }
   struct named *entry = &names->entry[names->count];
   entry->name = strdup(name);
   entry->link = link;
   if (!entry->name) return -1;
   names->bytes += length;
   ++names->count;
   return 0;
}

static int compare_names(const void *a, const void *b)
{
   return strcmp(((const struct named *)a)->name, ((const struct named *)b)->name);
}

#if H5_VERSION_GE(1, 12, 0)
typedef H5L_info2_t link_info;
#else
typedef H5L_info_t link_info;
#endif

static herr_t add_link(hid_t group, const char *name, const link_info *info, void *data)
{
   (void)group;
   return add_name(data, name, info->type == H5L_TYPE_HARD ? LINK_HARD
      : info->type == H5L_TYPE_SOFT ? LINK_SOFT : LINK_OTHER);
}

static herr_t add_attribute(hid_t object, const char *name, const H5A_info_t *info, void *data)
{
   (void)object;
   (void)info;
   return add_name(data, name, LINK_HARD);
}

struct names *contensou_hdf5_list(struct reader *reader, const char *object, int attributes)
{
   herr_t code = -1;
   struct names *names = calloc(1, sizeof *names);
   if (!names) {
      fail_read(reader, object, strerror(ENOMEM));
      return NULL;
   }
   contensou_guard_enter(reader->path, object);
   hid_t id = H5Oopen(reader->id, object, H5P_DEFAULT);
   if (id >= 0 && attributes) {
      code = H5Aiterate2(id, H5_INDEX_NAME, H5_ITER_INC, NULL, add_attribute, names);
   } else if (id >= 0) {
#if H5_VERSION_GE(1, 12, 0)
      code = H5Literate2(id, H5_INDEX_NAME, H5_ITER_INC, NULL, add_link, names);
#else
      code = H5Literate(id, H5_INDEX_NAME, H5_ITER_INC, NULL, add_link, names);
#endif
   }
   if (code < 0) {
      fail_read(reader, object, names->count == MAX_LINKS || names->bytes > MAX_NAMES / 2
         ? "it has too many members" : NULL);
   }
   if (id >= 0) H5Oclose(id);
   contensou_guard_leave();
   if (code < 0) {
      contensou_hdf5_free_list(names);
      return NULL;
   }
   if (names->count > 1) {
      qsort(names->entry, (size_t)names->count, sizeof *names->entry, compare_names);
   }
   return names;
}

int contensou_hdf5_listed_count(const struct names *names)
{
   return names->count;
}

const char *contensou_hdf5_listed(const struct names *names, int i, int *link)
{
   *link = names->entry[i].link;
   return names->entry[i].name;
}

int contensou_hdf5_object(struct reader *reader, const char *path, int64_t *address)
{
   contensou_guard_enter(reader->path, path);
#if H5_VERSION_GE(1, 12, 0)
   H5O_info2_t info;
   herr_t code = H5Oget_info_by_name3(reader->id, path, &info, H5O_INFO_BASIC, H5P_DEFAULT);
   if (code >= 0) memcpy(address, &info.token, sizeof *address);
#else
   H5O_info_t info;
   herr_t code = H5Oget_info_by_name2(reader->id, path, &info, H5O_INFO_BASIC, H5P_DEFAULT);
   if (code >= 0) *address = (int64_t)info.addr;
#endif
   if (code < 0) fail_read(reader, path, NULL);
   contensou_guard_leave();
   if (code < 0) return 0;
   return info.type == H5O_TYPE_GROUP ? OBJECT_GROUP
      : info.type == H5O_TYPE_DATASET ? OBJECT_DATASET
      : info.type == H5O_TYPE_NAMED_DATATYPE ? OBJECT_TYPE : OBJECT_OTHER;
}

/* Where a link leads that is not followed; null when that cannot be read. */
const char *contensou_hdf5_link_value(struct reader *reader, const char *path)
{
   static char value[8192];
   static char text[2 * sizeof value];
   const char *file = "";
   const char *object = "";
   link_info info;
   contensou_guard_enter(reader->path, path);
#if H5_VERSION_GE(1, 12, 0)
   herr_t code = H5Lget_info2(reader->id, path, &info, H5P_DEFAULT);
#else
   herr_t code = H5Lget_info(reader->id, path, &info, H5P_DEFAULT);
#endif
   if (code >= 0 && info.u.val_size >= sizeof value) {
      contensou_guard_leave();
      fail_read(reader, path, "a link of thousands of characters");
      return NULL;
   }
   memset(value, 0, sizeof value);
   if (code >= 0) code = H5Lget_val(reader->id, path, value, sizeof value - 1, H5P_DEFAULT);
   if (code >= 0 && info.type == H5L_TYPE_EXTERNAL) {
      unsigned flags = 0;
      code = H5Lunpack_elink_val(value, info.u.val_size, &flags, &file, &object);
   }
   if (code < 0) fail_read(reader, path, NULL);
   contensou_guard_leave();
   if (code < 0) return NULL;
   if (info.type == H5L_TYPE_EXTERNAL) {
      snprintf(text, sizeof text, "%s in the file %s", object, file);
   } else {
      snprintf(text, sizeof text, "%s", value);
   }
   return text;
}

/* ---- Reading: data sets and attributes ---- */

/* Whether values of a type hold addresses, so that their bytes mean nothing by themselves. */
static int has_addresses(hid_t type, int depth)
{
   H5T_class_t class = H5Tget_class(type);
   if (depth > 16 || class == H5T_NO_CLASS || class == H5T_VLEN || class == H5T_REFERENCE) return 1;
   if (class == H5T_STRING) return H5Tis_variable_str(type) != 0;
   int found = 0;
   if (class == H5T_COMPOUND) {
      int members = H5Tget_nmembers(type);
      if (members < 0) return 1;
      for (int i = 0; i < members && !found; ++i) {
         hid_t member = H5Tget_member_type(type, (unsigned)i);
         found = member < 0 || has_addresses(member, depth + 1);
         if (member >= 0) H5Tclose(member);
      }
   } else if (class == H5T_ARRAY) {
      hid_t base = H5Tget_super(type);
      found = base < 0 || has_addresses(base, depth + 1);
      if (base >= 0) H5Tclose(base);
   }
   return found;
}

/* Class of the values of an item, and words for its type. */
static int classify(struct item *item)
{
   H5T_class_t class = H5Tget_class(item->type);
   const unsigned bits = (unsigned)(8 * item->size);
   const char *name = "values of an unknown type";
   int is_unsigned = 0;
   item->class = CLASS_OTHER;
   switch (class) {
   case H5T_FLOAT:
      item->class = CLASS_REAL;
      snprintf(item->type_text, sizeof item->type_text, "%u-bit reals", bits);
      return 0;
   case H5T_ENUM: {
      hid_t base = H5Tget_super(item->type);
      is_unsigned = base >= 0 && H5Tget_sign(base) == H5T_SGN_NONE;
      if (base >= 0) H5Tclose(base);
      item->class = is_unsigned ? CLASS_UNSIGNED : CLASS_INTEGER;
      snprintf(item->type_text, sizeof item->type_text, "%u-bit enumerators", bits);
      return 0;
   }
   case H5T_INTEGER:
      is_unsigned = H5Tget_sign(item->type) == H5T_SGN_NONE;
      item->class = is_unsigned ? CLASS_UNSIGNED : CLASS_INTEGER;
      snprintf(item->type_text, sizeof item->type_text, "%s%u-bit integers",
         is_unsigned ? "unsigned " : "", bits);
      return 0;
   case H5T_STRING: {
      htri_t is_variable = H5Tis_variable_str(item->type);
      if (is_variable < 0) return 1;
      item->is_variable = is_variable > 0;
      item->class = CLASS_TEXT;
      snprintf(item->type_text, sizeof item->type_text, "texts");
      return 0;
   }
   case H5T_COMPOUND: name = "compound values"; break;
   case H5T_OPAQUE: name = "opaque values"; break;
   case H5T_BITFIELD: name = "bit fields"; break;
   case H5T_ARRAY: name = "values that are arrays"; break;
   case H5T_VLEN: name = "sequences of variable length"; break;
   case H5T_REFERENCE: name = "references"; break;
   default: break;
   }
   if (!has_addresses(item->type, 0)) item->class = CLASS_RAW;
   if (item->class == CLASS_RAW) {
      snprintf(item->type_text, sizeof item->type_text, "%s of %zu bytes", name, item->size);
   } else {
      snprintf(item->type_text, sizeof item->type_text, "%s", name);
   }
   return 0;
}

/* What an open item is: type, extents, and for a data set how it is stored. */
static int inspect_item(struct item *item)
{
   struct reader *reader = item->reader;
   const char *reason = NULL;
   size_t cache = 0;
   item->type = item->is_attribute ? H5Aget_type(item->id) : H5Dget_type(item->id);
   hid_t space = item->is_attribute ? H5Aget_space(item->id) : H5Dget_space(item->id);
   int failed = item->type < 0 || space < 0;
   if (!failed) {
      item->size = H5Tget_size(item->type);
      item->rank = H5Sget_simple_extent_ndims(space);
      item->is_null = H5Sget_simple_extent_type(space) == H5S_NULL;
      failed = item->size == 0 || item->rank < 0 || item->rank > H5S_MAX_RANK
         || (item->rank > 0 && H5Sget_simple_extent_dims(space, item->extents, NULL) < 0)
         || classify(item);
   }
   for (int i = 0; i < item->rank && !failed; ++i) {
      if (item->extents[i] > (hsize_t)INT64_MAX) reason = "a dimension is too long";
      item->chunk[i] = 0;
   }
   if (!failed && !item->is_attribute) {
      hid_t creation = H5Dget_create_plist(item->id);
      H5D_layout_t layout = creation < 0 ? H5D_LAYOUT_ERROR : H5Pget_layout(creation);
      failed = layout == H5D_LAYOUT_ERROR;
      if (layout == H5D_VIRTUAL
         || (layout == H5D_CONTIGUOUS && H5Pget_external_count(creation) > 0)) {
         reason = "its values are in another file";
      }
      if (layout == H5D_CHUNKED) {
         int rank = H5Pget_chunk(creation, H5S_MAX_RANK, item->chunk);
         double bytes = (double)item->size;
         for (int i = 0; i < rank; ++i) bytes *= (double)item->chunk[i];
         if (rank != item->rank) failed = 1;
         if (!failed && H5Pget_nfilters(creation) > 0) {
            if (bytes > MAX_PACKED_CHUNK) reason = "a compressed chunk has more than 128 MiB";
            if (bytes > 1024 * 1024) cache = (size_t)bytes + 1024;
         }
      }
      if (creation >= 0) H5Pclose(creation);
   }
   if (failed || reason) fail_read(reader, item->object, reason);
   if (space >= 0) H5Sclose(space);
   if (failed || reason) return 1;
   if (cache > 0) {
      /* A chunk that does not fit in the cache is uncompressed again for each part of it. */
      hid_t access = H5Dget_access_plist(item->id);
      hid_t again = H5I_INVALID_HID;
      if (access >= 0 && H5Pset_chunk_cache(access, 521, cache, 1.0) >= 0) {
         H5Dclose(item->id);
         again = item->id = H5Dopen2(reader->id, item->object, access);
      }
      if (again < 0) fail_read(reader, item->object, NULL);
      if (access >= 0) H5Pclose(access);
      if (again < 0) return 1;
   }
   return 0;
}

static void free_read_texts(struct item *item)
{
   while (item->arena.blocks) {
      struct arena_block *next = item->arena.blocks->next;
      free(item->arena.blocks);
      item->arena.blocks = next;
   }
   item->arena.used = 0;
   free(item->bytes);
   free(item->texts);
   item->bytes = NULL;
   item->texts = NULL;
   item->text_count = 0;
}

void contensou_hdf5_close_item(struct item *item)
{
   contensou_guard_enter(item->reader->path, item->object);
   if (item->type >= 0) H5Tclose(item->type);
   if (item->id >= 0) {
      if (item->is_attribute) {
         H5Aclose(item->id);
      } else {
         H5Dclose(item->id);
      }
   }
   contensou_guard_leave();
   free_read_texts(item);
   free(item->object);
   free(item);
}

/* An item without an identifier as yet. */
static struct item *new_item(struct reader *reader, const char *object, const char *attribute)
{
   size_t size = strlen(object) + strlen(attribute) + 2;
   struct item *item = calloc(1, sizeof *item);
   if (item) item->object = malloc(size);
   if (!item || !item->object) {
      free(item);
      fail_read(reader, object, strerror(ENOMEM));
      return NULL;
   }
   snprintf(item->object, size, "%s%s%s", object, attribute[0] ? "@" : "", attribute);
   item->reader = reader;
   item->id = item->type = H5I_INVALID_HID;
   item->is_attribute = attribute[0] != '\0';
   return item;
}

struct item *contensou_hdf5_open_item(struct reader *reader, const char *object,
   const char *attribute)
{
   struct item *item = new_item(reader, object, attribute);
   if (!item) return NULL;
   contensou_guard_enter(reader->path, item->object);
   item->id = item->is_attribute
      ? H5Aopen_by_name(reader->id, object, attribute, H5P_DEFAULT, H5P_DEFAULT)
      : H5Dopen2(reader->id, object, H5P_DEFAULT);
   int failed = item->id < 0;
   if (failed) fail_read(reader, item->object, NULL);
   if (!failed) failed = inspect_item(item);
   contensou_guard_leave();
   if (failed) {
      contensou_hdf5_close_item(item);
      return NULL;
   }
   return item;
}

static herr_t take_scale(hid_t dataset, unsigned dimension, hid_t scale, void *data)
{
   (void)dataset;
   (void)dimension;
   if (H5Iinc_ref(scale) < 0) return -1;
   *(hid_t *)data = scale;
   return 1;
}

/* The scale of a dimension under its name, or null if it has none that can be read. */
struct item *contensou_hdf5_open_scale(struct item *item, int dimension)
{
   char name[1024] = "";
   hid_t id = H5I_INVALID_HID;
   if (item->is_attribute || item->rank == 0) return NULL;
   contensou_guard_enter(item->reader->path, item->object);
   if (H5DSis_scale(item->id) > 0) {
      if (H5Iinc_ref(item->id) >= 0) id = item->id;
   } else if (H5DSget_num_scales(item->id, (unsigned)dimension) > 0) {
      H5DSiterate_scales(item->id, (unsigned)dimension, NULL, take_scale, &id);
   }
   if (id >= 0 && (H5DSget_scale_name(id, name, sizeof name) <= 0
      || strncmp(name, "This is a netCDF", 16) == 0)) {
      name[0] = '\0';
      if (H5Iget_name(id, name, sizeof name) < 0) name[0] = '\0';
   }
   name[sizeof name - 1] = '\0';
   const char *slash = strrchr(name, '/');
   struct item *scale = id >= 0 ? new_item(item->reader, slash ? slash + 1 : name, "") : NULL;
   if (scale) {
      scale->id = id;
      /* A compressed scale is not reopened: it has no path. */
      scale->type = H5Dget_type(id);
      hid_t space = H5Dget_space(id);
      int usable = scale->type >= 0 && space >= 0;
      if (usable) scale->size = H5Tget_size(scale->type);
      usable = usable && H5Sget_simple_extent_ndims(space) == 1
         && H5Sget_simple_extent_dims(space, scale->extents, NULL) == 1 && !classify(scale);
      scale->rank = 1;
      if (space >= 0) H5Sclose(space);
      if (!usable) {
         contensou_hdf5_close_item(scale);
         scale = NULL;
      }
   } else if (id >= 0) {
      H5Dclose(id);
   }
   contensou_guard_leave();
   return scale;
}

/* Label of a dimension without a scale; empty if it has none. */
const char *contensou_hdf5_dimension_name(struct item *item, int dimension)
{
   static char label[256];
   label[0] = '\0';
   if (item->is_attribute) return label;
   contensou_guard_enter(item->reader->path, item->object);
   if (H5DSget_label(item->id, (unsigned)dimension, label, sizeof label) < 0) label[0] = '\0';
   label[sizeof label - 1] = '\0';
   contensou_guard_leave();
   return label;
}

int contensou_hdf5_describe(const struct item *item, int64_t *size, int *rank, int64_t *extents,
   int64_t *chunk, int *is_null)
{
   *size = (int64_t)item->size;
   *rank = item->rank;
   *is_null = item->is_null;
   for (int i = 0; i < item->rank; ++i) {
      extents[i] = (int64_t)item->extents[i];
      chunk[i] = (int64_t)item->chunk[i];
   }
   return item->class;
}

const char *contensou_hdf5_type_text(const struct item *item)
{
   return item->type_text;
}

int contensou_hdf5_same_type(const struct item *a, const struct item *b)
{
   contensou_guard_enter(a->reader->path, a->object);
   int same = H5Tequal(a->type, b->type) > 0;
   contensou_guard_leave();
   return same;
}

/* Read a block, in the memory type given; conversions raise no floating-point exception. */
static int read_block(struct item *item, hid_t memory_type, hid_t transfer, const int64_t *start,
   const int64_t *count, void *buffer)
{
   hsize_t first[H5S_MAX_RANK];
   hsize_t number[H5S_MAX_RANK];
   fenv_t environment;
   herr_t code = -1;
   feholdexcept(&environment);
   if (item->is_attribute) {
      code = H5Aread(item->id, memory_type, buffer);
   } else if (item->rank == 0) {
      code = H5Dread(item->id, memory_type, H5S_ALL, H5S_ALL, transfer, buffer);
   } else {
      for (int i = 0; i < item->rank; ++i) {
         first[i] = (hsize_t)start[i];
         number[i] = (hsize_t)count[i];
      }
      hid_t stored = H5Dget_space(item->id);
      hid_t memory = H5Screate_simple(item->rank, number, NULL);
      if (stored >= 0 && memory >= 0
         && H5Sselect_hyperslab(stored, H5S_SELECT_SET, first, NULL, number, NULL) >= 0) {
         code = H5Dread(item->id, memory_type, memory, stored, transfer, buffer);
      }
      if (code < 0) fail_read(item->reader, item->object, NULL);
      if (memory >= 0) H5Sclose(memory);
      if (stored >= 0) H5Sclose(stored);
      fesetenv(&environment);
      return code < 0;
   }
   if (code < 0) fail_read(item->reader, item->object, NULL);
   fesetenv(&environment);
   return code < 0;
}

static double values_of(const struct item *item, const int64_t *count)
{
   double values = 1.0;
   for (int i = 0; i < item->rank; ++i) {
      values *= (double)(item->is_attribute ? (int64_t)item->extents[i] : count[i]);
   }
   return values;
}

int contensou_hdf5_read(struct item *item, const int64_t *start, const int64_t *count, int as_real,
   void *buffer)
{
   double values = values_of(item, count);
   if (spend(item->reader, item->object, values * (double)item->size)) return 1;
   contensou_guard_enter(item->reader->path, item->object);
   hid_t memory = item->type;
   if (item->class != CLASS_RAW) {
      memory = as_real || item->class == CLASS_REAL ? H5T_NATIVE_DOUBLE
         : item->class == CLASS_INTEGER ? H5T_NATIVE_INT64 : H5T_NATIVE_UINT64;
   }
   int failed = read_block(item, memory, H5P_DEFAULT, start, count, buffer);
   contensou_guard_leave();
   return failed;
}

static void *take_bytes(size_t size, void *data)
{
   struct arena *arena = data;
   if (size > MAX_TEXT - arena->used) return NULL;
   struct arena_block *block = malloc(sizeof *block + size);
   if (!block) return NULL;
   block->next = arena->blocks;
   arena->blocks = block;
   arena->used += size;
   return block->bytes;
}

static void leave_bytes(void *bytes, void *data)
{
   (void)bytes;
   (void)data;
}

/* Read texts of variable length. */
static int read_variable(struct item *item, const int64_t *start, const int64_t *count)
{
   int failed = 1;
   hid_t transfer = H5Pcreate(H5P_DATASET_XFER);
   if (transfer < 0 || H5Pset_vlen_mem_manager(transfer, take_bytes, &item->arena, leave_bytes,
      &item->arena) < 0) {
      fail_read(item->reader, item->object, NULL);
   } else {
      failed = read_block(item, item->type, transfer, start, count, item->texts);
   }
   if (transfer >= 0) H5Pclose(transfer);
   if (!failed && item->is_attribute) {
      /* Here HDF5 has allocated by itself. */
      for (size_t i = 0; i < item->text_count; ++i) {
         if (!item->texts[i]) continue;
         size_t size = strlen(item->texts[i]) + 1;
         char *copy = take_bytes(size, &item->arena);
         if (copy) memcpy(copy, item->texts[i], size);
         H5free_memory(item->texts[i]);
         item->texts[i] = copy;
         if (!copy) failed = fail_read(item->reader, item->object, "its texts are too long");
      }
   }
   return failed;
}

int contensou_hdf5_read_texts(struct item *item, const int64_t *start, const int64_t *count)
{
   double values = values_of(item, count);
   size_t unit = item->is_variable ? 0 : item->size + 1;
   free_read_texts(item);
   if (spend(item->reader, item->object, values * (double)(item->size + 64))) return 1;
   if (values * (double)(unit + sizeof *item->texts) > MAX_TEXT) {
      return fail_read(item->reader, item->object, "its texts are too long");
   }
   item->text_count = (size_t)values;
   item->texts = calloc(item->text_count + 1, sizeof *item->texts);
   if (unit > 0) item->bytes = malloc(item->text_count * unit + 1);
   if (!item->texts || (unit > 0 && !item->bytes)) {
      free_read_texts(item);
      return fail_read(item->reader, item->object, strerror(ENOMEM));
   }
   contensou_guard_enter(item->reader->path, item->object);
   int failed = 0;
   if (unit == 0) {
      failed = read_variable(item, start, count);
   } else {
      failed = read_block(item, item->type, H5P_DEFAULT, start, count, item->bytes);
      H5T_str_t padding = H5Tget_strpad(item->type);
      for (size_t i = item->text_count; i-- > 0 && !failed;) {
         /* Spread from the last to the first, to have room for a null character after each. */
         char *text = item->bytes + i * unit;
         memmove(text, item->bytes + i * item->size, item->size);
         text[item->size] = '\0';
         size_t used = strnlen(text, item->size);
         while (padding == H5T_STR_SPACEPAD && used > 0 && text[used - 1] == ' ') --used;
         text[used] = '\0';
         item->texts[i] = text;
      }
   }
   contensou_guard_leave();
   if (failed) free_read_texts(item);
   return failed;
}

const char *contensou_hdf5_text(const struct item *item, int64_t i)
{
   return item->texts[i] ? item->texts[i] : "";
}

/* Path of a data set, name of a scale. */
const char *contensou_hdf5_item_name(const struct item *item)
{
   return item->object;
}

/* The attribute `units` of a data set; empty if there is none that can be read. */
const char *contensou_hdf5_units(struct item *item)
{
   static char units[64];
   units[0] = '\0';
   if (item->is_attribute) return units;
   contensou_guard_enter(item->reader->path, item->object);
   htri_t exists = H5Aexists(item->id, "units");
   struct item *attribute = exists > 0 ? new_item(item->reader, item->object, "units") : NULL;
   int usable = 0;
   if (attribute) {
      attribute->id = H5Aopen(item->id, "units", H5P_DEFAULT);
      usable = attribute->id >= 0 && !inspect_item(attribute) && attribute->class == CLASS_TEXT
         && attribute->rank == 0 && !attribute->is_null;
   }
   contensou_guard_leave();
   int64_t none[1] = {0};
   if (usable && !contensou_hdf5_read_texts(attribute, none, none)) {
      snprintf(units, sizeof units, "%s", contensou_hdf5_text(attribute, 0));
   }
   if (attribute) contensou_hdf5_close_item(attribute);
   return units;
}

const char *contensou_hdf5_message(void)
{
   return last_message;
}

/* Version of the library in use, as "1.10.8". */
const char *contensou_hdf5_version(void)
{
   static char text[64];
   unsigned major = 0;
   unsigned minor = 0;
   unsigned release = 0;
   H5get_libversion(&major, &minor, &release);
   snprintf(text, sizeof text, "%u.%u.%u", major, minor, release);
   return text;
}
