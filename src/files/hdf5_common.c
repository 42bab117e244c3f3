/* What the writing and the reading of HDF5 files share. */
#include "hdf5_common.h"

char contensou_hdf5_reason[2048];

const char contensou_hdf5_in_use[] = "another program has it open";

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

int contensou_hdf5_explain(const char *verb, const char *path, const char *object)
{
   struct cause cause = {0, ""};
   H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, inspect, &cause);
   if (cause.code == EAGAIN || cause.code == EWOULDBLOCK) {
      contensou_hdf5_refuse(verb, path, NULL, contensou_hdf5_in_use);
   } else if (cause.code != 0) {
      contensou_hdf5_refuse(verb, path, NULL, strerror(cause.code));
   } else {
      char words[640];
      snprintf(words, sizeof words, "%sHDF5 says \"%s\"",
         strcmp(verb, "read") == 0 ? "it is damaged, " : "",
         cause.text[0] ? cause.text : "no reason given");
      contensou_hdf5_refuse(verb, path, object, words);
   }
   return cause.code;
}

int contensou_hdf5_refuse(const char *verb, const char *path, const char *object,
   const char *reason)
{
   int has_object = object && object[0];
   snprintf(contensou_hdf5_reason, sizeof contensou_hdf5_reason, "cannot %s %s%s%s: %s", verb, path,
      has_object ? ", object " : "", has_object ? object : "", reason);
   return 1;
}

void contensou_hdf5_start(void)
{
   static int started = 0;
   if (!started) H5dont_atexit();
   started = 1;
   H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
}

hid_t contensou_hdf5_text_type(void)
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

hid_t contensou_hdf5_access(int locking)
{
   hid_t access = H5Pcreate(H5P_FILE_ACCESS);
   if (access < 0) return access;
   if (H5Pset_fclose_degree(access, H5F_CLOSE_STRONG) < 0
#if H5_VERSION_GE(1, 12, 1) || (H5_VERS_MINOR == 10 && H5_VERS_RELEASE >= 7)
      || H5Pset_file_locking(access, locking, 1) < 0
#endif
   ) {
      H5Pclose(access);
      return H5I_INVALID_HID;
   }
   return access;
}

const char *contensou_hdf5_message(void)
{
   return contensou_hdf5_reason;
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
