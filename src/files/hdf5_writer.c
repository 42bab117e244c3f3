/*
 * Writing of HDF5 files in the manner of netCDF-4. Values come from Fortran as they are, with their
 * type, rank and extents; those of a Fortran array are in the reverse order of the file's.
 */
#include "hdf5_common.h"

#include <ISO_Fortran_binding.h>
#include <fcntl.h>
#include <stddef.h>
#include <unistd.h>

/* Kinds of values, as hdf5_file.f90 knows them. */
enum { KIND_NONE = 0, KIND_REAL = 1, KIND_INTEGER = 2, KIND_TEXT = 3, KIND_LONG = 4, KIND_BYTE = 5 };

/* Extents of the largest data set, and the largest chunk in bytes. */
enum { MAX_RANK = 8, MAX_CHUNK = 4 * 1024 * 1024 };

/* Bytes of the buffer in which texts become what the file holds, many at a time. */
enum { CONVERSION_BUFFER = 2 * 1024 };

/* How long to wait for one who only looks whether a file is in use [s]. */
static const double lock_patience = 0.2;

struct series;

/* A dimension of a data set, as the attribute REFERENCE_LIST of its scale holds it. */
struct use {
   hobj_ref_t dataset;
   int dimension;
};

/* A dimension scale that is open, as many data sets have it. */
struct scale {
   struct scale *next;
   hid_t id;
   hobj_ref_t reference;
   /* The dimensions that have it, and how many of them the file speaks of. */
   struct use *uses;
   size_t count;
   size_t room;
   size_t written;
   char path[];
};

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
   struct scale *scales;
   /* Room for a chunk. */
   char *chunk;
   size_t chunk_room;
};

/* A data set that grows along its first dimension. */
struct series {
   struct file *file;
   struct series *next;
   hid_t id;
   int kind;
   int rank;
   hsize_t extents[MAX_RANK];
   /* Rows of a chunk that is written as it is, with its checksum; 0 for none. */
   hsize_t whole_rows;
};

struct file *contensou_hdf5_create(const char *path);
int contensou_hdf5_flush(struct file *file);
int contensou_hdf5_sync(struct file *file);
int contensou_hdf5_bound_memory(struct file *file);
int contensou_hdf5_close(struct file *file);
int contensou_hdf5_close_as(struct file *file, const char *name, int replace);
int contensou_system_rename(const char *from, const char *to, int replace);
int contensou_system_take_lock(const char *path, double patience, int *descriptor);
int contensou_system_share_lock(double patience, int descriptor);
void contensou_hdf5_abandon(struct file *file);
int contensou_hdf5_create_group(struct file *file, const char *path);
int contensou_hdf5_put_attribute(struct file *file, const char *object, const char *name,
   const CFI_cdesc_t *array);
int contensou_hdf5_put_dataset(struct file *file, const char *path, const CFI_cdesc_t *array,
   const CFI_cdesc_t *scales, int is_scale, const char *units, const char *long_name);
struct series *contensou_hdf5_create_series(struct file *file, const char *path, int kind,
   const CFI_cdesc_t *extents, int chunk_rows, int compress, const CFI_cdesc_t *scales, int is_scale,
   const char *units, const char *long_name);
int contensou_hdf5_append(struct series *series, int rows, const CFI_cdesc_t *array,
   const char *path);

/* ---- Errors ---------------------------------------------------------------------------------- */

/* Note a failed write; the file then takes nothing but its release. */
static int fail(struct file *file, const char *object)
{
   if (!file->failed) contensou_hdf5_explain("write", file->path, object);
   file->failed = 1;
   return 1;
}

/* Note a failure that is not HDF5's. */
static int fail_because(struct file *file, const char *object, const char *reason)
{
   if (!file->failed) contensou_hdf5_refuse("write", file->path, object, reason);
   file->failed = 1;
   return 1;
}

/* ---- Text ------------------------------------------------------------------------------------ */

/* Values of Fortran as HDF5 takes them. */
struct values {
   int kind;
   int rank;
   /* Outermost first. */
   hsize_t extents[MAX_RANK];
   size_t count;
   const void *data;
   /* Texts as C strings. */
   char **item;
   char *bytes;
};

static void free_values(struct values *values)
{
   free(values->item);
   free(values->bytes);
   values->item = NULL;
   values->bytes = NULL;
}

static int kind_of(const CFI_cdesc_t *array)
{
   if (array->type == CFI_type_double) return KIND_REAL;
   if (array->type == CFI_type_int32_t) return KIND_INTEGER;
   if (array->type == CFI_type_int64_t) return KIND_LONG;
   if (array->type == CFI_type_int8_t) return KIND_BYTE;
   return array->type == CFI_type_char ? KIND_TEXT : KIND_NONE;
}

/* Why an array cannot be written, or null. A single text is content and stays as it is unless
   `trim` is set; blanks fill up the items of an array. */
static const char *take_values(struct values *values, const CFI_cdesc_t *array, int trim)
{
   memset(values, 0, sizeof *values);
   values->kind = kind_of(array);
   values->rank = array->rank;
   values->data = array->base_addr;
   if (values->kind == KIND_NONE) return "values of a type that no file has";
   if (array->rank > MAX_RANK) return "too many dimensions";
   values->count = 1;
   for (int i = 0; i < array->rank; ++i) {
      values->extents[i] = (hsize_t)array->dim[array->rank - 1 - i].extent;
      values->count *= (size_t)values->extents[i];
   }
   if (values->kind != KIND_TEXT) return NULL;
   size_t length = array->elem_len;
   values->item = malloc((values->count + 1) * sizeof *values->item);
   values->bytes = malloc(values->count * (length + 1) + 1);
   if (!values->item || !values->bytes) {
      free_values(values);
      return strerror(ENOMEM);
   }
   char *to = values->bytes;
   for (size_t i = 0; i < values->count; ++i) {
      const char *from = (const char *)array->base_addr + i * length;
      size_t used = length;
      while ((trim || array->rank > 0) && used > 0 && from[used - 1] == ' ') --used;
      memcpy(to, from, used);
      to[used] = '\0';
      values->item[i] = to;
      to += used + 1;
   }
   values->data = values->item;
   return NULL;
}

/* ---- What objects have in common ------------------------------------------------------------- */

/* Types, properties and the space of a single value. Except where a caller is said to, nobody
   closes them: to make them anew for each object took a tenth of the time of a small file. */

static hid_t file_type(int kind)
{
   if (kind == KIND_REAL) return H5T_IEEE_F64LE;
   if (kind == KIND_INTEGER) return H5T_STD_I32LE;
   if (kind == KIND_LONG) return H5T_STD_I64LE;
   if (kind == KIND_BYTE) return H5T_STD_I8LE;
   return contensou_hdf5_text_type();
}

static hid_t memory_type(int kind)
{
   if (kind == KIND_REAL) return H5T_NATIVE_DOUBLE;
   if (kind == KIND_INTEGER) return H5T_NATIVE_INT32;
   if (kind == KIND_LONG) return H5T_NATIVE_INT64;
   if (kind == KIND_BYTE) return H5T_NATIVE_INT8;
   return contensou_hdf5_text_type();
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

/* Properties for writing a file: a format that HDF5 1.8 reads, which has no mark "open for
   writing" either that would make a killed run's file unreadable. It is locked by other means. */
static hid_t access_list(void)
{
   hid_t access = contensou_hdf5_access(0);
   if (access < 0) return access;
   if (H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18) < 0
      || hold_metadata(access) < 0) {
      H5Pclose(access);
      return H5I_INVALID_HID;
   }
   return access;
}

/* Close the data sets that were kept open. */
static void close_datasets(const struct file *file)
{
   for (struct series *series = file->series; series; series = series->next) H5Dclose(series->id);
   for (struct scale *scale = file->scales; scale; scale = scale->next) H5Dclose(scale->id);
}

static void release(struct file *file)
{
   if (file->lock >= 0) close(file->lock);
   while (file->series) {
      struct series *next = file->series->next;
      free(file->series);
      file->series = next;
   }
   while (file->scales) {
      struct scale *next = file->scales->next;
      free(file->scales->uses);
      free(file->scales);
      file->scales = next;
   }
   free(file->chunk);
   free(file->path);
   free(file);
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
   contensou_hdf5_start();
   struct file *file = calloc(1, sizeof *file);
   if (file) file->path = strdup(path);
   if (!file || !file->path) {
      free(file);
      contensou_hdf5_refuse("create", path, NULL, strerror(ENOMEM));
      return NULL;
   }
   /* HDF5 itself would empty the file first and ask for its lock afterwards. */
   int refused = contensou_system_take_lock(path, lock_patience, &file->lock);
   if (refused) {
      contensou_hdf5_refuse("create", path, NULL,
         refused < 0 ? contensou_hdf5_in_use : strerror(refused));
      release(file);
      return NULL;
   }
   hid_t access = access_list();
   hid_t creation = H5Pcreate(H5P_FILE_CREATE);
   file->id = H5I_INVALID_HID;
   if (access >= 0 && creation >= 0 && H5Pset_link_creation_order(creation, order) >= 0
      && H5Pset_attr_creation_order(creation, order) >= 0
      && H5Pset_obj_track_times(creation, 0) >= 0) {
      file->id = H5Fcreate(path, H5F_ACC_TRUNC, creation, access);
   }
   int code = file->id < 0 ? contensou_hdf5_explain("create", path, NULL) : 0;
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

/* Type of a use of a scale, as H5DSattach_scale writes it. */
static hid_t use_type(void)
{
   static hid_t kept = H5I_INVALID_HID;
   if (kept >= 0) return kept;
   hid_t type = H5Tcreate(H5T_COMPOUND, sizeof(struct use));
   if (type >= 0
      && (H5Tinsert(type, "dataset", offsetof(struct use, dataset), H5T_STD_REF_OBJ) < 0
         || H5Tinsert(type, "dimension", offsetof(struct use, dimension), H5T_NATIVE_INT) < 0)) {
      H5Tclose(type);
      type = H5I_INVALID_HID;
   }
   return kept = type;
}

/* Tell the scales which data sets have them. All at once, as each of them takes the whole list to
   be written anew: by H5DSattach_scale, one at a time, a fifth of the time of a small file. */
static int put_uses(struct file *file)
{
   static const char name[] = "REFERENCE_LIST";
   for (struct scale *scale = file->scales; scale; scale = scale->next) {
      if (scale->written == scale->count) continue;
      hsize_t count = scale->count;
      hid_t type = use_type();
      hid_t space = H5Screate_simple(1, &count, NULL);
      hid_t attribute = H5I_INVALID_HID;
      if (type >= 0 && space >= 0 && (scale->written == 0 || H5Adelete(scale->id, name) >= 0)) {
         attribute = H5Acreate2(scale->id, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
      }
      int failed = attribute < 0 || H5Awrite(attribute, type, scale->uses) < 0;
      if (failed) fail(file, scale->path);
      if (attribute >= 0) H5Aclose(attribute);
      if (space >= 0) H5Sclose(space);
      if (failed) return 1;
      scale->written = scale->count;
   }
   return 0;
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
   if (file->failed || put_uses(file) || reserve(file)) return 1;
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
   close_datasets(file);
   int failed = H5Fclose(file->id) < 0;
   if (failed) contensou_hdf5_explain("close", file->path, NULL);
   int unsealed = !failed && name ? contensou_hdf5_seal(file->lock, file->path) : 0;
   if (unsealed) failed = contensou_hdf5_refuse("write", file->path, NULL, strerror(unsealed));
   /* Who waits for the name may read the file as soon as it is there. */
   if (!failed && name && contensou_system_share_lock(lock_patience, file->lock)) {
      failed = contensou_hdf5_refuse("write", file->path, NULL, contensou_hdf5_in_use);
   }
   if (!failed && name) {
      int code = contensou_system_rename(file->path, name, replace);
      if (code) {
         snprintf(contensou_hdf5_reason, sizeof contensou_hdf5_reason,
            "cannot rename %s to %s: %s", file->path, name, strerror(code));
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
   close_datasets(file);
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

int contensou_hdf5_put_attribute(struct file *file, const char *object, const char *name,
   const CFI_cdesc_t *array)
{
   if (file->failed) return 1;
   int failed = 0;
   struct values values;
   const char *reason = take_values(&values, array, 1);
   if (reason) return fail_because(file, object, reason);
   hid_t target = H5Oopen(file->id, object, H5P_DEFAULT);
   if (target < 0) {
      failed = fail(file, object);
   } else {
      failed = write_attribute(file, target, 0, name, values.kind, values.rank, values.count,
         values.data);
      H5Oclose(target);
   }
   free_values(&values);
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

/* A dimension scale by its path, opened once; null on failure. */
static struct scale *find_scale(struct file *file, const char *path)
{
   for (struct scale *scale = file->scales; scale; scale = scale->next) {
      if (strcmp(scale->path, path) == 0) return scale;
   }
   size_t size = strlen(path) + 1;
   struct scale *scale = calloc(1, sizeof *scale + size);
   if (!scale) return NULL;
   scale->id = H5Dopen2(file->id, path, H5P_DEFAULT);
   if (scale->id < 0 || H5DSis_scale(scale->id) <= 0
      || H5Rcreate(&scale->reference, scale->id, ".", H5R_OBJECT, H5I_INVALID_HID) < 0) {
      if (scale->id >= 0) H5Dclose(scale->id);
      free(scale);
      return NULL;
   }
   memcpy(scale->path, path, size);
   scale->next = file->scales;
   file->scales = scale;
   return scale;
}

/* Note that a dimension of a data set has a scale; 0 or errno. */
static int note_use(struct scale *scale, hobj_ref_t dataset, size_t dimension)
{
   if (scale->count == scale->room) {
      size_t room = scale->room > 0 ? 2 * scale->room : 8;
      struct use *uses = realloc(scale->uses, room * sizeof *uses);
      if (!uses) return ENOMEM;
      scale->uses = uses;
      scale->room = room;
   }
   /* With zeros between and behind its parts, so that equal content gives equal files. */
   struct use *use = scale->uses + scale->count++;
   memset(use, 0, sizeof *use);
   use->dataset = dataset;
   use->dimension = (int)dimension;
   return 0;
}

/* Give a data set its scales, one for each dimension, as H5DSattach_scale does. */
static int attach_scales(struct file *file, hid_t dataset, const char *path,
   const struct values *names)
{
   static hid_t type = H5I_INVALID_HID;
   hobj_ref_t own;
   hvl_t lists[MAX_RANK];
   hsize_t rank = names->count;
   if (rank > MAX_RANK) return fail_because(file, path, "too many dimensions");
   if (H5Rcreate(&own, dataset, ".", H5R_OBJECT, H5I_INVALID_HID) < 0) return fail(file, path);
   for (size_t i = 0; i < rank; ++i) {
      struct scale *scale = find_scale(file, names->item[i]);
      if (!scale) return fail(file, names->item[i]);
      lists[i].len = 1;
      lists[i].p = &scale->reference;
      int code = note_use(scale, own, i);
      if (code) return fail_because(file, path, strerror(code));
   }
   if (type < 0) type = H5Tvlen_create(H5T_STD_REF_OBJ);
   hid_t space = H5Screate_simple(1, &rank, NULL);
   hid_t attribute = H5I_INVALID_HID;
   if (type >= 0 && space >= 0) {
      attribute = H5Acreate2(dataset, "DIMENSION_LIST", type, space, H5P_DEFAULT, H5P_DEFAULT);
   }
   int failed = attribute < 0 || H5Awrite(attribute, type, lists) < 0;
   if (failed) fail(file, path);
   if (attribute >= 0) H5Aclose(attribute);
   if (space >= 0) H5Sclose(space);
   return failed;
}

/* Give a data set its dimension scales, outermost first, or make it one. */
static int set_dimensions(struct file *file, hid_t dataset, const char *path,
   const CFI_cdesc_t *scales, int is_scale)
{
   int failed = 0;
   struct values names;
   if (is_scale) {
      const char *slash = strrchr(path, '/');
      if (H5DSset_scale(dataset, slash ? slash + 1 : path) < 0) return fail(file, path);
   }
   const char *reason = take_values(&names, scales, 1);
   if (reason) return fail_because(file, path, reason);
   if (names.count > 0) failed = attach_scales(file, dataset, path, &names);
   free_values(&names);
   return failed;
}

/* Create a data set with its attributes and scales; an invalid identifier on failure. */
static hid_t create_dataset(struct file *file, const char *path, int kind, hid_t space,
   hid_t creation, hid_t access, const CFI_cdesc_t *scales, int is_scale, const char *units,
   const char *long_name)
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
      || set_dimensions(file, dataset, path, scales, is_scale)) {
      H5Dclose(dataset);
      dataset = H5I_INVALID_HID;
   }
   return dataset;
}

int contensou_hdf5_put_dataset(struct file *file, const char *path, const CFI_cdesc_t *array,
   const CFI_cdesc_t *scales, int is_scale, const char *units, const char *long_name)
{
   if (file->failed) return 1;
   if (scales->dim[0].extent != (is_scale ? 0 : array->rank)) {
      return fail_because(file, path, "the number of scales is not that of dimensions");
   }
   struct values values;
   const char *reason = take_values(&values, array, 0);
   if (reason) return fail_because(file, path, reason);
   int failed = 0;
   hid_t memory = memory_type(values.kind);
   hid_t space = values.rank == 0 ? single_space()
                                  : H5Screate_simple(values.rank, values.extents, NULL);
   hid_t dataset = create_dataset(file, path, values.kind, space, dataset_list(), H5P_DEFAULT,
      scales, is_scale, units, long_name);
   if (dataset < 0) {
      failed = 1;
   } else if (values.count > 0
      && (memory < 0
         || H5Dwrite(dataset, memory, H5S_ALL, H5S_ALL, transfer_list(), values.data) < 0)) {
      failed = fail(file, path);
   }
   if (dataset >= 0) H5Dclose(dataset);
   if (values.rank > 0 && space >= 0) H5Sclose(space);
   free_values(&values);
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
static herr_t set_chunks(struct series *series, hid_t creation, hid_t access, hsize_t rows,
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
   /* Damage of a chunk is an error when it is read; texts are stored elsewhere. */
   int sum = series->kind != KIND_TEXT && H5Zfilter_avail(H5Z_FILTER_FLETCHER32) > 0;
   if (sum && H5Pset_fletcher32(creation) < 0) return -1;
   if (sum && !compress && row % 2 == 0 && H5Tequal(file_type(series->kind),
      memory_type(series->kind)) > 0) series->whole_rows = chunk[0];
   /* What lies behind the last row need not be filled, except for texts, which are addresses, and
      in what goes through a filter, which would not be the same twice. */
   if (series->kind != KIND_TEXT && !compress && !sum
      && H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER) < 0) return -1;
   return H5Pset_chunk_cache(access, 0, 0, 0.0);
}

struct series *contensou_hdf5_create_series(struct file *file, const char *path, int kind,
   const CFI_cdesc_t *extents, int chunk_rows, int compress, const CFI_cdesc_t *scales, int is_scale,
   const char *units, const char *long_name)
{
   int rank = (int)extents->dim[0].extent;
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
   } else if (scales->dim[0].extent != (is_scale ? rank : rank + 1) || (is_scale && rank > 0)) {
      fail_because(file, path, "the number of scales is not that of dimensions");
   } else {
      most[0] = H5S_UNLIMITED;
      for (int i = 0; i < rank; ++i) {
         most[i + 1] = series->extents[i + 1] = (hsize_t)((const int *)extents->base_addr)[i];
      }
      hid_t space = H5Screate_simple(series->rank, series->extents, most);
      hid_t creation = creation_list(H5P_DATASET_CREATE);
      hid_t access = H5Pcreate(H5P_DATASET_ACCESS);
      if (creation >= 0 && access >= 0
         && set_chunks(series, creation, access, chunk_rows > 0 ? (hsize_t)chunk_rows : 1, compress)
            < 0) {
         fail(file, path);
      } else {
         series->id = create_dataset(file, path, kind, space, creation, access, scales, is_scale,
            units, long_name);
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

/* The checksum that HDF5 puts behind a chunk: Fletcher-32 of words of two bytes, the first one the
   upper. Here words have the first byte as the lower one, which only turns the sums (modulo 2^16 - 1)
   by a byte, and several sums run beside each other: that takes a tenth of the time. A sum is never
   zero unless all words are, as in HDF5. */
static uint32_t chunk_checksum(const unsigned char *bytes, size_t size)
{
   enum { LANES = 8, ROUNDS = 360, MODULUS = 65535 };
   size_t left = size / 2;
   uint64_t sum = 0;
   uint64_t sum_of_sums = 0;
   while (left > 0) {
      /* So many rounds that no sum of 32 bits overflows. */
      size_t rounds = left / LANES < ROUNDS ? left / LANES : ROUNDS;
      size_t lanes = rounds > 0 ? LANES : left;
      uint32_t first[LANES] = {0};
      uint32_t second[LANES] = {0};
      if (rounds == 0) {
         for (size_t k = 0; k < lanes; ++k) {
            first[k] = second[k] = (uint32_t)bytes[2 * k] | (uint32_t)bytes[2 * k + 1] << 8;
         }
         rounds = 1;
      } else {
         for (size_t i = 0; i < rounds; ++i) {
            uint16_t words[LANES];
            memcpy(words, bytes + 2 * LANES * i, sizeof words);
            for (size_t k = 0; k < LANES; ++k) first[k] += words[k];
            for (size_t k = 0; k < LANES; ++k) second[k] += first[k];
         }
      }
      uint64_t words = rounds * lanes;
      uint64_t added = 0;
      uint64_t weighted = words * sum;
      for (size_t k = 0; k < lanes; ++k) {
         added += first[k];
         weighted += (uint64_t)lanes * second[k] - k * first[k];
      }
      sum_of_sums += weighted;
      sum += added;
      if (sum > 0) sum = (sum - 1) % MODULUS + 1;
      if (sum_of_sums > 0) sum_of_sums = (sum_of_sums - 1) % MODULUS + 1;
      bytes += 2 * words;
      left -= words;
   }
   uint32_t low = (uint32_t)(sum & 255) << 8 | (uint32_t)(sum >> 8);
   uint32_t high = (uint32_t)(sum_of_sums & 255) << 8 | (uint32_t)(sum_of_sums >> 8);
   return high << 16 | low;
}

/* Write rows that begin a chunk, up to all of it, as HDF5 would; the data set has been extended.
   Past all that HDF5 does for any selection of values, that saves as much again as the checksum. */
static int write_chunk(struct series *series, const hsize_t *start, hsize_t rows, const void *data)
{
   struct file *file = series->file;
   size_t row = row_size(series);
   size_t whole = (size_t)series->whole_rows * row;
   size_t used = (size_t)rows * row;
   if (file->chunk_room < whole + 4) {
      char *room = realloc(file->chunk, whole + 4);
      if (!room) return fail_because(file, NULL, strerror(ENOMEM));
      file->chunk = room;
      file->chunk_room = whole + 4;
   }
   memcpy(file->chunk, data, used);
   memset(file->chunk + used, 0, whole - used);
   uint32_t sum = chunk_checksum((const unsigned char *)file->chunk, whole);
   for (int i = 0; i < 4; ++i) file->chunk[whole + i] = (char)(sum >> 8 * i & 255);
   if (H5Dwrite_chunk(series->id, H5P_DEFAULT, 0, start, whole + 4, file->chunk) < 0) {
      return fail(file, NULL);
   }
   return 0;
}

/* Write rows behind those that the data set has. */
static int write_rows(struct series *series, hsize_t rows, const char *data)
{
   hsize_t start[MAX_RANK] = {0};
   hsize_t count[MAX_RANK];
   memcpy(count, series->extents, sizeof count);
   start[0] = series->extents[0];
   series->extents[0] += rows;
   if (H5Dset_extent(series->id, series->extents) < 0) return fail(series->file, NULL);
   if (row_values(series) == 0) return 0;
   while (rows > 0 && series->whole_rows > 0 && start[0] % series->whole_rows == 0) {
      hsize_t written = rows < series->whole_rows ? rows : series->whole_rows;
      if (write_chunk(series, start, written, data)) return 1;
      start[0] += written;
      data += written * row_size(series);
      rows -= written;
   }
   if (rows == 0) return 0;
   count[0] = rows;
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

int contensou_hdf5_append(struct series *series, int rows, const CFI_cdesc_t *array,
   const char *path)
{
   struct values values;
   if (series->file->failed) return 1;
   if (kind_of(array) != series->kind) {
      snprintf(contensou_hdf5_reason, sizeof contensou_hdf5_reason,
         "values of the wrong type appended to %s", path);
      return 1;
   }
   const char *reason = take_values(&values, array, 1);
   if (reason) return fail_because(series->file, path, reason);
   int failed = values.count < (rows > 0 ? (size_t)rows : 0) * row_values(series);
   if (failed) {
      snprintf(contensou_hdf5_reason, sizeof contensou_hdf5_reason,
         "too few values appended to %s", path);
   } else if (rows > 0) {
      /* An empty text is a null address, which takes no place elsewhere in the file. */
      for (size_t i = 0; values.item && i < values.count; ++i) {
         if (values.item[i][0] == '\0') values.item[i] = NULL;
      }
      failed = write_rows(series, (hsize_t)rows, values.data);
   }
   free_values(&values);
   return failed;
}
