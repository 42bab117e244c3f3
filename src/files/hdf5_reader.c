/*
 * Reading of any HDF5 file, piece by piece.
 */
#include "hdf5_common.h"

#include <ISO_Fortran_binding.h>
#include <fenv.h>
#include <stddef.h>
#include <time.h>

struct reader;
struct item;
struct names;
struct reader *contensou_hdf5_open_reader(const char *path, int lenient);
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
int contensou_hdf5_read(struct item *item, const int64_t *start, const int64_t *count,
   const CFI_cdesc_t *buffer);
int contensou_hdf5_read_texts(struct item *item, const int64_t *start, const int64_t *count);
const char *contensou_hdf5_text(const struct item *item, int64_t i);
const char *contensou_hdf5_item_name(const struct item *item);
const char *contensou_hdf5_units(struct item *item);

/* src/base/guard.c */
void contensou_guard_enter(const char *path, const char *object);
void contensou_guard_leave(void);

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
   /* Whether chunks are read whose checksums are wrong. */
   int lenient;
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
   if (reason) return contensou_hdf5_refuse("read", reader->path, object, reason);
   contensou_hdf5_explain("read", reader->path, object && object[0] ? object : NULL);
   return 1;
}

/* Open a file; wait a little for who has just written it, and holds its lock until it has its name.
   The reason of a failure is composed. */
static hid_t open_patiently(const char *path, hid_t access)
{
   enum { TRIES = 20 };
   for (int i = 1;; ++i) {
      hid_t id = H5Fopen(path, H5F_ACC_RDONLY, access);
      if (id >= 0) return id;
      int code = contensou_hdf5_explain("read", path, NULL);
      if ((code != EAGAIN && code != EWOULDBLOCK) || i == TRIES) return id;
      nanosleep(&(struct timespec){0, 10 * 1000 * 1000}, NULL);
   }
}

struct reader *contensou_hdf5_open_reader(const char *path, int lenient)
{
   struct stat info;
   contensou_hdf5_start();
   struct reader *reader = calloc(1, sizeof *reader);
   if (reader) reader->path = strdup(path);
   if (!reader || !reader->path) {
      free(reader);
      contensou_hdf5_refuse("read", path, NULL, strerror(ENOMEM));
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
      reader->lenient = lenient;
      contensou_guard_enter(path, "");
      int damaged = contensou_hdf5_check_seal(path) == SEAL_BROKEN;
      hid_t access = damaged ? H5I_INVALID_HID : contensou_hdf5_access(1);
      if (access >= 0 && limit_metadata(access) >= 0) {
         reader->id = open_patiently(path, access);
      } else if (!damaged) {
         contensou_hdf5_explain("read", path, NULL);
      }
      if (damaged) {
         fail_read(reader, NULL, "it is damaged, its content is not that of its checksum");
      } else if (reader->id < 0) {
         htri_t known = 1;
         H5E_BEGIN_TRY known = H5Fis_hdf5(path); H5E_END_TRY
         if (known == 0) fail_read(reader, NULL, "it is not an HDF5 file, or damaged");
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

/* Properties for reading values, damaged ones if the reader takes them; nobody closes them. */
static hid_t transfer_list(const struct reader *reader)
{
   static hid_t kept = H5I_INVALID_HID;
   if (!reader->lenient) return H5P_DEFAULT;
   if (kept < 0) {
      kept = H5Pcreate(H5P_DATASET_XFER);
      if (kept < 0 || H5Pset_edc_check(kept, H5Z_DISABLE_EDC) < 0) return H5P_DEFAULT;
   }
   return kept;
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

int contensou_hdf5_read(struct item *item, const int64_t *start, const int64_t *count,
   const CFI_cdesc_t *buffer)
{
   double values = values_of(item, count);
   if (spend(item->reader, item->object, values * (double)item->size)) return 1;
   contensou_guard_enter(item->reader->path, item->object);
   hid_t memory = item->type;
   if (item->class != CLASS_RAW) {
      memory = buffer->type == CFI_type_double ? H5T_NATIVE_DOUBLE
         : item->class == CLASS_INTEGER ? H5T_NATIVE_INT64 : H5T_NATIVE_UINT64;
   }
   int failed = read_block(item, memory, transfer_list(item->reader), start, count,
      buffer->base_addr);
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
   if (transfer < 0 || (item->reader->lenient && H5Pset_edc_check(transfer, H5Z_DISABLE_EDC) < 0)
      || H5Pset_vlen_mem_manager(transfer, take_bytes, &item->arena, leave_bytes, &item->arena)
         < 0) {
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
