/* Writes the FMU of a scene: description, scene, binary and sources in a zip file without
 * compression, which any importer reads. */
#define _GNU_SOURCE
#include "variables.h"

#include <dirent.h>
#include <errno.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#ifndef FMU_FOLDER
#define FMU_FOLDER "../lib/contensou/fmu"
#endif

/* Bytes that grow. */
typedef struct {
   char *bytes;
   size_t size, room;
   int failed;
} buffer;

static void put(buffer *to, const void *bytes, size_t size)
{
   if (to->failed) return;
   if (to->size + size > to->room) {
      size_t room = 2 * (to->size + size) + 4096;
      char *longer = realloc(to->bytes, room);
      if (!longer) {
         to->failed = 1;
         return;
      }
      to->bytes = longer;
      to->room = room;
   }
   if (size) memcpy(to->bytes + to->size, bytes, size);
   to->size += size;
}

static void say(buffer *to, const char *format, ...)
{
   char *text = NULL;
   va_list arguments;
   int n;
   va_start(arguments, format);
   n = vasprintf(&text, format, arguments);
   va_end(arguments);
   if (n < 0) {
      to->failed = 1;
      return;
   }
   put(to, text, (size_t)n);
   free(text);
}

/* An attribute, its value escaped. */
static void attribute(buffer *to, const char *name, const char *value)
{
   say(to, " %s=\"", name);
   for (; *value; value++) {
      if (*value == '&') put(to, "&amp;", 5);
      else if (*value == '<') put(to, "&lt;", 4);
      else if (*value == '>') put(to, "&gt;", 4);
      else if (*value == '"') put(to, "&quot;", 6);
      else if ((unsigned char)*value < ' ') put(to, " ", 1);
      else put(to, value, 1);
   }
   put(to, "\"", 1);
}

/* ---- Zip ------------------------------------------------------------------------------------- */

typedef struct {
   buffer data, directory;
   unsigned entries;
} archive;

static uint32_t crc_of(const unsigned char *bytes, size_t n)
{
   static const uint32_t nibble[16] = {
      0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4, 0x4db26158, 0x5005713c,
      0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c, 0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};
   uint32_t crc = 0xffffffffu;
   while (n--) {
      crc = nibble[(crc ^ *bytes) & 15] ^ (crc >> 4);
      crc = nibble[(crc ^ (*bytes++ >> 4)) & 15] ^ (crc >> 4);
   }
   return ~crc;
}

static void number(buffer *to, uint32_t value, int bytes)
{
   while (bytes--) {
      char byte = (char)(value & 255);
      put(to, &byte, 1);
      value >>= 8;
   }
}

static void add_file(archive *to, const char *name, const char *bytes, size_t size)
{
   uint32_t crc = crc_of((const unsigned char *)bytes, size), place = (uint32_t)to->data.size;
   int pass;

   /* The same header twice: before the bytes, and in the directory. The time is 1980-01-01. */
   for (pass = 0; pass < 2; pass++) {
      buffer *at = pass ? &to->directory : &to->data;
      number(at, pass ? 0x02014b50 : 0x04034b50, 4);
      if (pass) number(at, 0x0314, 2);
      number(at, 20, 2);
      number(at, 0, 2);
      number(at, 0, 2);
      number(at, 0, 2);
      number(at, 33, 2);
      number(at, crc, 4);
      number(at, (uint32_t)size, 4);
      number(at, (uint32_t)size, 4);
      number(at, (uint32_t)strlen(name), 2);
      number(at, 0, 2);
      if (pass) {
         number(at, 0, 2);
         number(at, 0, 2);
         number(at, 0, 2);
         number(at, 0100644u << 16, 4);
         number(at, place, 4);
      }
      put(at, name, strlen(name));
   }
   put(&to->data, bytes, size);
   to->entries++;
}

static void finish(archive *to)
{
   uint32_t place = (uint32_t)to->data.size, size = (uint32_t)to->directory.size;
   put(&to->data, to->directory.bytes, to->directory.size);
   number(&to->data, 0x06054b50, 4);
   number(&to->data, 0, 4);
   number(&to->data, to->entries, 2);
   number(&to->data, to->entries, 2);
   number(&to->data, size, 4);
   number(&to->data, place, 4);
   number(&to->data, 0, 2);
   to->data.failed |= to->directory.failed;
}

/* ---- Description ----------------------------------------------------------------------------- */

static const char *const causalities[] = {"independent", "parameter", "input", "output",
                                          "local", "local", "local"};

static void describe_variable(buffer *to, const fmu_variables *list, int i, int fmi)
{
   const fmu_variable *item = &list->items[i];
   int given = item->kind == FMU_PARAMETER || item->kind == FMU_INPUT;

   say(to, fmi == 2 ? "    <ScalarVariable" : "    <Float64");
   attribute(to, "name", item->name);
   say(to, " valueReference=\"%d\" causality=\"%s\" variability=\"%s\"", i,
       causalities[item->kind], item->kind == FMU_PARAMETER ? "fixed" : "continuous");
   attribute(to, "description", item->description);
   if (item->kind == FMU_PARAMETER) say(to, " initial=\"exact\"");
   if (item->kind >= FMU_OUTPUT) say(to, " initial=\"calculated\"");
   if (fmi == 2) say(to, ">\n      <Real");
   if (given) say(to, " start=\"%.17g\"", item->start);
   if (*item->unit) attribute(to, "unit", item->unit);
   if (item->kind == FMU_RATE)
      say(to, " derivative=\"%d\"", list->first[FMU_STATE] + item->place + (fmi == 2));
   say(to, fmi == 2 ? "/>\n    </ScalarVariable>\n" : "/>\n");
}

static void list_unknowns(buffer *to, const fmu_variables *list, int kind, int fmi, const char *word)
{
   int i;
   for (i = 0; i < list->count[kind]; i++) {
      int place = list->first[kind] + i;
      if (fmi == 2) say(to, "      <Unknown index=\"%d\"/>\n", place + 1);
      else say(to, "    <%s valueReference=\"%d\"/>\n", word, place);
   }
}

/* Files of C, then their headers. */
enum { SOURCES = 7, COMPILED = 4 };
static const char *const sources[SOURCES] = {"variables.c", "instance.c", "places.c",
                                             "handle_table.c", "variables.h", "instance.h",
                                             "contensou.h"};

static void name_sources(buffer *to, int fmi)
{
   int i;
   for (i = 0; i < COMPILED; i++) say(to, "      <File name=\"%s\"/>\n", sources[i]);
   say(to, "      <File name=\"fmu%d.c\"/>\n", fmi);
}

static void describe_interface(buffer *to, const char *word, const char *model, int fmi,
                               const char *more)
{
   say(to, "  <%s", word);
   attribute(to, "modelIdentifier", model);
   if (fmi == 2) {
      say(to, " canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\"%s>\n", more);
      say(to, "    <SourceFiles>\n");
      name_sources(to, fmi);
      say(to, "    </SourceFiles>\n  </%s>\n", word);
   } else {
      say(to, " canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\"%s/>\n", more);
   }
}

static void describe(buffer *to, const fmu_variables *list, int fmi, const char *title,
                     const char *model, const char *token, double end, double rtol)
{
   int i, j;

   say(to, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"%d.0\"", fmi);
   attribute(to, "modelName", title);
   attribute(to, fmi == 2 ? "guid" : "instantiationToken", token);
   say(to, " generationTool=\"Contensou %s\" variableNamingConvention=\"flat\"", contensou_version());
   if (fmi == 2) say(to, " numberOfEventIndicators=\"%d\"", list->count[FMU_INDICATOR]);
   say(to, ">\n");
   describe_interface(to, "ModelExchange", model, fmi,
                      fmi == 2 ? "" : " needsCompletedIntegratorStep=\"true\"");
   describe_interface(to, "CoSimulation", model, fmi,
                      fmi == 2 ? " canHandleVariableCommunicationStepSize=\"true\""
                               : " canHandleVariableCommunicationStepSize=\"true\" hasEventMode="
                                 "\"true\" canReturnEarlyAfterIntermediateUpdate=\"true\"");
   say(to, "  <UnitDefinitions>\n");
   for (i = 0; i < list->n; i++) {
      if (!*list->items[i].unit) continue;
      for (j = 0; j < i && strcmp(list->items[i].unit, list->items[j].unit); j++) continue;
      if (j < i) continue;
      say(to, "    <Unit");
      attribute(to, "name", list->items[i].unit);
      say(to, "/>\n");
   }
   say(to, "  </UnitDefinitions>\n");
   say(to, "  <DefaultExperiment startTime=\"0\" stopTime=\"%.17g\" tolerance=\"%.17g\" "
           "stepSize=\"%.17g\"/>\n  <ModelVariables>\n", end, rtol, end / 1000.0);
   for (i = 0; i < list->n; i++) describe_variable(to, list, i, fmi);
   say(to, "  </ModelVariables>\n  <ModelStructure>\n");
   if (fmi == 2) say(to, "    <Outputs>\n");
   list_unknowns(to, list, FMU_OUTPUT, fmi, "Output");
   if (fmi == 2) say(to, "    </Outputs>\n");
   if (fmi == 2 && list->count[FMU_RATE] > 0) say(to, "    <Derivatives>\n");
   list_unknowns(to, list, FMU_RATE, fmi, "ContinuousStateDerivative");
   if (fmi == 2 && list->count[FMU_RATE] > 0) say(to, "    </Derivatives>\n");
   if (fmi == 2) say(to, "    <InitialUnknowns>\n");
   list_unknowns(to, list, FMU_OUTPUT, fmi, "InitialUnknown");
   list_unknowns(to, list, FMU_STATE, fmi, "InitialUnknown");
   list_unknowns(to, list, FMU_RATE, fmi, "InitialUnknown");
   if (fmi == 2) {
      say(to, "    </InitialUnknowns>\n");
   } else {
      list_unknowns(to, list, FMU_INDICATOR, fmi, "EventIndicator");
   }
   say(to, "  </ModelStructure>\n</fmiModelDescription>\n");
}

/* ---- The package ----------------------------------------------------------------------------- */

/* The path of a file in a folder that is told from where the program lies; "" where that is not
 * known. */
static void own_path(char *path, size_t room, const char *folder, const char *name)
{
   char here[4096];
   ssize_t length = readlink("/proc/self/exe", here, sizeof here - 1);

   *path = 0;
   if (length <= 0) return;
   here[length] = 0;
   *strrchr(here, '/') = 0;
   snprintf(path, room, "%s/%s/%s", here, folder, name);
}

/* Read a file that belongs to the program. */
static int read_in(const char *folder, const char *name, buffer *to)
{
   char path[8192], bytes[65536];
   size_t n;
   FILE *file;

   memset(to, 0, sizeof *to);
   own_path(path, sizeof path, folder, name);
   file = fopen(path, "rb");
   if (!file) return 0;
   while ((n = fread(bytes, 1, sizeof bytes, file)) > 0) put(to, bytes, n);
   if (ferror(file)) to->failed = 1;
   fclose(file);
   return !to->failed;
}

/* Read one from where it was built, or is installed. */
static int read_own(const char *name, buffer *to)
{
   static const char *const folders[] = {"../fmu", FMU_FOLDER};
   int i;

   for (i = 0; i < 2; i++) {
      if (read_in(folders[i], name, to)) return 1;
      if (i == 0) free(to->bytes);
   }
   return 0;
}

/* Put the libraries that the binary needs of those that the program brings along beside it: all.
 * Returns whether each was read. */
static int add_libraries(archive *zip, const char *binaries)
{
#ifdef FMU_LIBRARIES
   char path[8192], entry[512];
   const struct dirent *item;
   int whole = 1;
   DIR *folder;

   own_path(path, sizeof path, FMU_LIBRARIES, "");
   folder = opendir(path);
   /* Before libraries are brought along, those of the machine are used. */
   if (!folder) return 1;
   while (whole && (item = readdir(folder))) {
      buffer own;
      if (*item->d_name == '.') continue;
      whole = read_in(FMU_LIBRARIES, item->d_name, &own);
      snprintf(entry, sizeof entry, "binaries/%s/%s", binaries, item->d_name);
      if (whole) add_file(zip, entry, own.bytes, own.size);
      free(own.bytes);
   }
   closedir(folder);
   return whole;
#else
   (void)zip;
   (void)binaries;
   return 1;
#endif
}

static void model_of(const char *output, char model[64])
{
   const char *slash = strrchr(output, '/');
   int i = 0;
   if (slash) output = slash + 1;
   if (*output >= '0' && *output <= '9') model[i++] = '_';
   for (; *output && *output != '.' && i < 63; output++, i++) {
      char c = *output;
      int plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
      model[i] = plain ? c : '_';
   }
   if (i == 0) model[i++] = '_';
   model[i] = 0;
}

/* Whether a contact can be alone: its number, or -1 and a message. */
static int alone(contensou_simulation *simulation, const char *name, char *message, size_t room)
{
   contensou_error *error = NULL;
   int i, n = contensou_simulation_size(simulation), contact = fmu_contact_of(simulation, name);
   double *state = malloc((size_t)n * sizeof *state);

   if (contact < 0) {
      snprintf(message, room, "there is no contact '%s' in the scene, expected one of:", name);
      for (i = 0; i < contensou_simulation_contacts(simulation) && strlen(message) + 2 < room; i++)
         snprintf(message + strlen(message), room - strlen(message), "%s '%s'", i ? "," : "",
                  contensou_simulation_contact_name(simulation, i));
   } else if (state) {
      contensou_simulation_state(simulation, state);
      if (contensou_simulation_contact_load(simulation, contact, state, n, NULL, NULL, NULL,
                                            &error) == 2) {
         snprintf(message, room, "%s cannot be an FMU: %s", name, contensou_error_message(error));
         contact = -1;
      }
      contensou_error_free(error);
   }
   free(state);
   return contact;
}

int contensou_fmu_write(const char *name, const char *scene, const char *const settings[], int n,
                        const char *contact, int fmi, const char *title, const char *output,
                        const char *place, char *message, size_t room);

/* Write the FMU of a scene, given as a text with n settings, or unless its name is "" of a contact
 * alone, to a place where it waits for its name, which the model inside is called after. Returns 0,
 * 2 for a mistake in the scene, or 74 for a file, and then a message. */
int contensou_fmu_write(const char *name, const char *scene, const char *const settings[], int n,
                        const char *contact, int fmi, const char *title, const char *output,
                        const char *place, char *message, size_t room)
{
   contensou_error *error = NULL;
   contensou_simulation *simulation;
   fmu_variables list = {0};
   archive zip = {{0}, {0}, 0};
   buffer text = {0}, own;
   char model[64], entry[256], token[64];
   const char *binaries = fmi == 2 ? "linux64" : "x86_64-linux";
   double rtol = 1e-8;
   FILE *file;
   int i, number = -1, whole, reason, status = 74;

   *message = 0;
   simulation = contensou_simulation_from_text(name, scene, settings, n, &error);
   if (!simulation) {
      snprintf(message, room, "%s", contensou_error_message(error));
      status = contensou_error_status(error);
      contensou_error_free(error);
      return status;
   }
   model_of(output, model);
   contensou_simulation_get(simulation, "integrator.rtol", &rtol, NULL);
   if (*contact) {
      number = alone(simulation, contact, message, room);
      if (number < 0) {
         status = 2;
         goto end;
      }
      add_file(&zip, "resources/contact.txt", contact, strlen(contact));
   }
   if (fmu_list(simulation, number, &list)) {
      snprintf(message, room, "there is no memory for the variables");
      goto end;
   }
   for (i = 0; i < n; i++) say(&text, "%s\n", settings[i]);
   snprintf(token, sizeof token, "{contensou-%08x-%08x-%d}",
            (unsigned)crc_of((const unsigned char *)scene, strlen(scene)),
            (unsigned)crc_of((const unsigned char *)text.bytes, text.size), number);
   add_file(&zip, "resources/scene.nml", scene, strlen(scene));
   add_file(&zip, "resources/settings.txt", text.bytes, text.size);
   text.size = 0;
   describe(&text, &list, fmi, *title ? title : model, model, token,
            contensou_simulation_end(simulation), rtol);
   add_file(&zip, "modelDescription.xml", text.bytes, text.size);
   snprintf(entry, sizeof entry, "contensou_fmu%d.so", fmi);
   if (!read_own(entry, &own)) {
      free(own.bytes);
      snprintf(message, room, "%s is not beside the program, nor where it is installed", entry);
      goto end;
   }
   snprintf(entry, sizeof entry, "binaries/%s/%s.so", binaries, model);
   add_file(&zip, entry, own.bytes, own.size);
   free(own.bytes);
   if (!add_libraries(&zip, binaries)) {
      snprintf(message, room, "the libraries of the program cannot be read");
      goto end;
   }
   for (i = 0; i <= SOURCES; i++) {
      char source[16];
      snprintf(source, sizeof source, "fmu%d.c", fmi);
      if (!read_own(i < SOURCES ? sources[i] : source, &own)) {
         free(own.bytes);
         snprintf(message, room, "%s is not beside the program, nor where it is installed",
                  i < SOURCES ? sources[i] : source);
         goto end;
      }
      snprintf(entry, sizeof entry, "sources/%s", i < SOURCES ? sources[i] : source);
      add_file(&zip, entry, own.bytes, own.size);
      free(own.bytes);
   }
   if (fmi == 3) {
      text.size = 0;
      say(&text, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiBuildDescription fmiVersion=\"3.0\">\n"
                 "  <BuildConfiguration modelIdentifier=\"%s\">\n    <SourceFileSet language=\"C11\">\n",
          model);
      for (i = 0; i < COMPILED; i++) say(&text, "      <SourceFile name=\"%s\"/>\n", sources[i]);
      say(&text, "      <SourceFile name=\"fmu3.c\"/>\n    </SourceFileSet>\n"
                 "    <Library name=\"contensou\" external=\"true\"/>\n"
                 "  </BuildConfiguration>\n</fmiBuildDescription>\n");
      add_file(&zip, "sources/buildDescription.xml", text.bytes, text.size);
   }
   finish(&zip);
   file = zip.data.failed || text.failed ? NULL : fopen(place, "wb");
   if (!file) {
      snprintf(message, room, "cannot write %s: %s", place, strerror(errno));
      goto end;
   }
   /* A full disk may show only as it is closed. */
   whole = fwrite(zip.data.bytes, 1, zip.data.size, file) == zip.data.size;
   reason = errno;
   if (fclose(file) != 0) {
      if (whole) reason = errno;
      whole = 0;
   }
   if (whole) {
      status = 0;
   } else {
      remove(place);
      snprintf(message, room, "cannot write %s: %s", place, strerror(reason));
   }
end:
   fmu_release(&list);
   contensou_simulation_free(simulation);
   free(text.bytes);
   free(zip.data.bytes);
   free(zip.directory.bytes);
   return status;
}
