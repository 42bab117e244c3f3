/*
 * Writing of HDF5 files in the manner of netCDF-4: the one place that names HDF5. The Fortran side
 * is hdf5_file.f90, where the functions are documented.
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
#include <hdf5.h>
#include <hdf5_hl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

enum { KIND_REAL = 1, KIND_INTEGER = 2, KIND_TEXT = 3, KIND_LONG = 4 };

/* Extents of the largest data set, and the largest chunk in bytes. */
enum { MAX_RANK = 8, MAX_CHUNK = 4 * 1024 * 1024 };

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
   const int64_t *extents, int64_t chunk_rows, int scale_count, const char *scales,
   size_t scale_length, int is_scale, const char *units, const char *long_name);
int contensou_hdf5_append(struct series *series, int64_t rows, const void *data, const char *text,
   size_t length);
int contensou_hdf5_read_status(const char *path, char *status, size_t size);
const char *contensou_hdf5_message(void);
const char *contensou_hdf5_version(void);

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

/* Type of a variable-length UTF-8 string, in the file as in memory. */
static hid_t text_type(void)
{
   hid_t type = H5Tcopy(H5T_C_S1);
   if (type >= 0
      && (H5Tset_size(type, H5T_VARIABLE) < 0 || H5Tset_cset(type, H5T_CSET_UTF8) < 0)) {
      H5Tclose(type);
      type = H5I_INVALID_HID;
   }
   return type;
}

static hid_t file_type(int kind)
{
   if (kind == KIND_REAL) return H5Tcopy(H5T_IEEE_F64LE);
   if (kind == KIND_INTEGER) return H5Tcopy(H5T_STD_I32LE);
   if (kind == KIND_LONG) return H5Tcopy(H5T_STD_I64LE);
   return text_type();
}

static hid_t memory_type(int kind)
{
   if (kind == KIND_REAL) return H5Tcopy(H5T_NATIVE_DOUBLE);
   if (kind == KIND_INTEGER) return H5Tcopy(H5T_NATIVE_INT32);
   if (kind == KIND_LONG) return H5Tcopy(H5T_NATIVE_INT64);
   return text_type();
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

int contensou_hdf5_flush(struct file *file)
{
   if (file->failed || reserve(file)) return 1;
   if (H5Fflush(file->id, H5F_SCOPE_LOCAL) < 0) return fail(file, NULL);
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

/* Properties for creating an object: order of attributes kept, no times, so that equal content
   gives equal files. */
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

/* Properties for naming an object. */
static hid_t link_list(void)
{
   hid_t list = H5Pcreate(H5P_LINK_CREATE);
   if (list >= 0 && H5Pset_char_encoding(list, H5T_CSET_UTF8) < 0) {
      H5Pclose(list);
      list = H5I_INVALID_HID;
   }
   return list;
}

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
   if (links >= 0) H5Pclose(links);
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
   hid_t creation = H5Pcreate(H5P_ATTRIBUTE_CREATE);
   if (creation < 0) return creation;
   hid_t attribute = H5I_INVALID_HID;
   if (H5Pset_char_encoding(creation, H5T_CSET_UTF8) >= 0) {
      attribute = H5Acreate2(object, name, type, space, creation, H5P_DEFAULT);
   }
   H5Pclose(creation);
   return attribute;
}

/* Write an attribute of an open object; data are as HDF5 takes them. */
static int write_attribute(struct file *file, hid_t object, const char *name, int kind, int rank,
   hsize_t count, const void *data)
{
   int failed = 0;
   hid_t stored = file_type(kind);
   hid_t memory = memory_type(kind);
   hid_t space = rank == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, NULL);
   hid_t attribute = H5I_INVALID_HID;
   if (stored >= 0 && memory >= 0 && space >= 0) {
      attribute = provide_attribute(object, name, stored, space);
   }
   if (attribute < 0 || ((rank == 0 || count > 0) && H5Awrite(attribute, memory, data) < 0)) {
      failed = fail(file, name);
   }
   if (attribute >= 0) H5Aclose(attribute);
   if (space >= 0) H5Sclose(space);
   if (memory >= 0) H5Tclose(memory);
   if (stored >= 0) H5Tclose(stored);
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
      failed = write_attribute(file, target, name, kind, rank, (hsize_t)count,
         kind == KIND_TEXT ? (const void *)texts.item : data);
   }
   free_texts(&texts);
   if (target >= 0) H5Oclose(target);
   return failed;
}

/* Write the attributes that every data set has. */
static int describe(struct file *file, hid_t dataset, const char *units, const char *long_name)
{
   if (units[0] != '\0' && write_attribute(file, dataset, "units", KIND_TEXT, 0, 1, &units)) {
      return 1;
   }
   return write_attribute(file, dataset, "long_name", KIND_TEXT, 0, 1, &long_name);
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
   if (type >= 0) H5Tclose(type);
   if (links >= 0) H5Pclose(links);
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
   hid_t space = rank == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(rank, size, NULL);
   hid_t creation = creation_list(H5P_DATASET_CREATE);
   hid_t dataset = create_dataset(file, path, kind, space, creation, H5P_DEFAULT, scale_count,
      scales, scale_length, is_scale, units, long_name);
   if (dataset < 0) {
      failed = 1;
   } else if (values > 0
      && (memory < 0
         || H5Dwrite(dataset, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT,
               kind == KIND_TEXT ? (const void *)texts.item : data) < 0)) {
      failed = fail(file, path);
   }
   if (dataset >= 0) H5Dclose(dataset);
   if (creation >= 0) H5Pclose(creation);
   if (space >= 0) H5Sclose(space);
   if (memory >= 0) H5Tclose(memory);
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
   size_t size = series->kind == KIND_TEXT ? 16 : series->kind == KIND_INTEGER ? 4 : 8;
   return size * row_values(series);
}

/* Set chunks of that many rows, fewer if the rows are long. Without a cache rows go straight to
   their place on the disk: a full disk is noticed by the append that meets it, while the metadata
   still speak of the rows before. */
static herr_t set_chunks(const struct series *series, hid_t creation, hid_t access, hsize_t rows)
{
   hsize_t chunk[MAX_RANK];
   size_t row = row_size(series);
   if (row > 0 && rows > MAX_CHUNK / row) rows = MAX_CHUNK / row;
   chunk[0] = rows > 0 ? rows : 1;
   for (int i = 1; i < series->rank; ++i) chunk[i] = series->extents[i] ? series->extents[i] : 1;
   if (H5Pset_chunk(creation, series->rank, chunk) < 0) return -1;
   /* What lies behind the last row need not be filled, except for texts, which are addresses. */
   if (series->kind != KIND_TEXT && H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER) < 0) return -1;
   return H5Pset_chunk_cache(access, 0, 0, 0.0);
}

struct series *contensou_hdf5_create_series(struct file *file, const char *path, int kind, int rank,
   const int64_t *extents, int64_t chunk_rows, int scale_count, const char *scales,
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
         && set_chunks(series, creation, access, chunk_rows > 0 ? (hsize_t)chunk_rows : 1) < 0) {
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
      || H5Dwrite(series->id, type, memory, stored, H5P_DEFAULT, data) < 0;
   if (failed) fail(series->file, NULL);
   if (memory >= 0) H5Sclose(memory);
   if (stored >= 0) H5Sclose(stored);
   if (type >= 0) H5Tclose(type);
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
   if (type >= 0) H5Tclose(type);
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
