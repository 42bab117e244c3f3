#include "variables.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char *copy_of(const char *text)
{
   char *copy = malloc(strlen(text) + 1);
   return copy ? strcpy(copy, text) : NULL;
}

static fmu_variable *add(fmu_variables *list, int kind, const char *unit, const char *description,
                         const char *format, ...)
{
   char name[512];
   va_list arguments;
   fmu_variable *item;

   if ((list->n & (list->n - 1)) == 0) {
      fmu_variable *longer = realloc(list->items, (list->n ? 2 * (size_t)list->n : 1) *
                                                     sizeof *longer);
      if (!longer) return NULL;
      list->items = longer;
   }
   va_start(arguments, format);
   vsnprintf(name, sizeof name, format, arguments);
   va_end(arguments);
   item = &list->items[list->n];
   memset(item, 0, sizeof *item);
   item->kind = kind;
   item->name = copy_of(name);
   item->unit = copy_of(unit);
   item->description = copy_of(description);
   if (list->count[kind]++ == 0) list->first[kind] = list->n;
   list->n++;
   return item->name && item->unit && item->description ? item : NULL;
}

int fmu_take_loads(contensou_simulation *simulation, contensou_error **error)
{
   int i, status = CONTENSOU_OK;
   if (error) *error = NULL;
   for (i = 0; i < contensou_simulation_bodies(simulation) && status == CONTENSOU_OK; i++) {
      double force[3], torque[3];
      if (contensou_simulation_motion(simulation, i) != CONTENSOU_FREE) continue;
      contensou_simulation_load(simulation, i, force, torque);
      status = contensou_simulation_set_load(simulation,
                                             contensou_simulation_body_name(simulation, i), force,
                                             torque, error);
   }
   return status;
}

static int add_inputs(contensou_simulation *simulation, fmu_variables *list)
{
   static const char *const axes = "xyz";
   int i, k;

   for (i = 0; i < contensou_simulation_bodies(simulation); i++) {
      const char *body = contensou_simulation_body_name(simulation, i);
      int motion = contensou_simulation_motion(simulation, i);
      double start[6] = {0.0};
      int free = motion == CONTENSOU_FREE;

      if (motion == CONTENSOU_FIXED) continue;
      if (free) contensou_simulation_load(simulation, i, start, start + 3);
      for (k = 0; k < 6; k++) {
         fmu_variable *item;
         if (motion == CONTENSOU_SPINDLE && k < 3) continue;
         item = free ? add(list, FMU_INPUT, k < 3 ? "N" : "N.m",
                           k < 3 ? "force applied at the centre of mass" : "torque applied",
                           "%s.%s.%c", body, k < 3 ? "force" : "torque", axes[k % 3])
                     : add(list, FMU_INPUT, k < 3 ? "m/s2" : "rad/s2",
                           k < 3 ? "acceleration by the drive, beside that of the scene"
                                 : "angular acceleration by the drive, beside that of the scene",
                           "%s.%s.%c", body, k < 3 ? "acceleration" : "angular_acceleration",
                           axes[k % 3]);
         if (!item) return -1;
         item->object = i;
         item->place = k;
         item->start = start[k];
      }
   }
   return 0;
}

/* Quantities of the rows; of one contact only unless that is negative. */
static int add_outputs(contensou_simulation *simulation, int contact, fmu_variables *list)
{
   int i, k;

   for (i = 0; i < contensou_simulation_quantities(simulation); i++) {
      contensou_quantity quantity;
      contensou_simulation_quantity(simulation, i, &quantity);
      if (!strcmp(quantity.name, "time")) continue;
      if (contact >= 0 && (quantity.rank == 0 || strcmp(quantity.dims[0], "contact"))) continue;
      for (k = 0; k < quantity.size; k++) {
         const char *const dims = quantity.dims[1];
         int components = quantity.shape[1], object = k / components;
         const char *name = quantity.rank == 0 ? ""
                            : !strcmp(quantity.dims[0], "body")
                               ? contensou_simulation_body_name(simulation, object)
                               : contensou_simulation_contact_name(simulation, object);
         const char *dot = quantity.rank == 0 ? "" : ".";
         fmu_variable *item;
         if (contact >= 0 && object != contact) continue;
         if (quantity.rank < 2)
            item = add(list, FMU_OUTPUT, quantity.units, quantity.description, "%s%s%s", name, dot,
                       quantity.name);
         else if (!strcmp(dims, "axis"))
            item = add(list, FMU_OUTPUT, quantity.units, quantity.description, "%s.%s.%c", name,
                       quantity.name, "ab"[k % components]);
         else
            item = add(list, FMU_OUTPUT, quantity.units, quantity.description, "%s.%s.%c", name,
                       quantity.name, dims[k % components]);
         if (!item) return -1;
         item->object = i;
         item->place = k;
      }
   }
   return 0;
}

static int add_indicator(contensou_simulation *simulation, int contact, fmu_variables *list)
{
   fmu_variable *item = add(list, FMU_INDICATOR, "", "zero where the contact touches or lifts off",
                            "%s.indicator", contensou_simulation_contact_name(simulation, contact));
   if (!item) return -1;
   item->place = list->count[FMU_INDICATOR] - 1;
   return 0;
}

void fmu_turn(const double quaternion[4], int back, const double vector[3], double turned[3])
{
   const double w = back ? -quaternion[0] : quaternion[0], *axis = quaternion + 1;
   double square = w * w, dot = 0.0;
   int i;

   for (i = 0; i < 3; i++) {
      square += axis[i] * axis[i];
      dot += axis[i] * vector[i];
   }
   for (i = 0; i < 3; i++) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      const double across = axis[j] * vector[k] - axis[k] * vector[j];
      turned[i] = vector[i] + 2.0 * (w * across + axis[i] * dot -
                                     (square - w * w) * vector[i]) / square;
   }
}

int fmu_contact_of(const contensou_simulation *simulation, const char *name)
{
   int i = contensou_simulation_contacts(simulation);
   while (--i >= 0 && strcmp(contensou_simulation_contact_name(simulation, i), name)) continue;
   return i;
}

/* Poses and velocities of the bodies of a contact, and what it does to them. */
static int add_element(contensou_simulation *simulation, int contact, fmu_variables *list)
{
   static const struct {
      const char *name, *unit, *description, *components;
   } inputs[] = {{"position", "m", "centre of mass", "xyz"},
                 {"quaternion", "1", "attitude, body to inertial frame", "wxyz"},
                 {"velocity", "m/s", "velocity of the centre of mass", "xyz"},
                 {"angular_velocity", "rad/s", "angular velocity, inertial frame", "xyz"}};
   int n = contensou_simulation_size(simulation), side, i, k;
   double *state = malloc((size_t)n * sizeof *state), turned[3];
   fmu_variable *item;

   if (!state) return -1;
   contensou_simulation_state(simulation, state);
   for (side = 0; side < 2; side++) {
      int body = contensou_simulation_contact_body(simulation, contact, side), place = 0;
      if (body < 0) continue;
      fmu_turn(state + 13 * body + 3, 0, state + 13 * body + 10, turned);
      memcpy(state + 13 * body + 10, turned, sizeof turned);
      for (i = 0; i < 4; i++)
         for (k = 0; inputs[i].components[k]; k++) {
            item = add(list, FMU_INPUT, inputs[i].unit, inputs[i].description, "%s.%s.%c",
                       contensou_simulation_body_name(simulation, body), inputs[i].name,
                       inputs[i].components[k]);
            if (!item) break;
            item->object = body;
            item->place = place;
            item->start = state[13 * body + place++];
         }
   }
   free(state);
   for (side = 0; side < 2; side++) {
      int body = contensou_simulation_contact_body(simulation, contact, side);
      const char *name = body < 0 ? "ground" : contensou_simulation_body_name(simulation, body);
      for (k = 0; k < 6; k++) {
         item = add(list, FMU_OUTPUT, k < 3 ? "N" : "N.m",
                    k < 3 ? "force of the contact, inertial frame"
                    : body < 0 ? "its torque about the origin, inertial frame"
                               : "its torque about the centre of mass, inertial frame",
                    "%s.%s.%c", name, k < 3 ? "force" : "torque", "xyz"[k % 3]);
         if (!item) return -1;
         item->object = side ? FMU_ON_B : FMU_ON_A;
         item->place = k;
      }
   }
   if (add_outputs(simulation, contact, list)) return -1;
   return add_indicator(simulation, contact, list);
}

int fmu_list(contensou_simulation *simulation, int contact, fmu_variables *list)
{
   double *state;
   int i, n;

   memset(list, 0, sizeof *list);
   if (!add(list, FMU_TIME, "s", "time", "time")) return -1;
   n = contensou_simulation_parameters(simulation);
   for (i = 0; i < n; i++) {
      contensou_parameter parameter;
      fmu_variable *item;
      contensou_simulation_parameter(simulation, i, &parameter);
      item = add(list, FMU_PARAMETER, parameter.unit, parameter.description, "%s", parameter.name);
      if (!item) return -1;
      item->start = parameter.value;
      item->is_integer = parameter.is_integer;
      item->place = i;
   }
   if (contact >= 0) return add_element(simulation, contact, list);
   if (add_inputs(simulation, list) || add_outputs(simulation, -1, list)) return -1;
   if (fmu_take_loads(simulation, NULL)) return -1;
   n = contensou_simulation_size(simulation);
   state = malloc((size_t)n * sizeof *state);
   if (!state) return -1;
   contensou_simulation_state(simulation, state);
   for (i = 0; i < n; i++) {
      fmu_variable *item = add(list, FMU_STATE, "", "number of the state", "state[%d]", i + 1);
      if (!item) break;
      item->start = state[i];
      item->place = i;
   }
   free(state);
   if (i < n) return -1;
   for (i = 0; i < n; i++) {
      fmu_variable *item = add(list, FMU_RATE, "", "its rate", "der(state[%d])", i + 1);
      if (!item) return -1;
      item->place = i;
   }
   n = contensou_simulation_contacts(simulation);
   for (i = 0; i < n; i++) {
      if (add_indicator(simulation, i, list)) return -1;
   }
   if (contensou_simulation_remembers(simulation)) {
      fmu_variable *item = add(list, FMU_INDICATOR, "",
                               "zero where contacts have to remember an accepted step",
                               "memory_indicator");
      if (!item) return -1;
      item->place = list->count[FMU_INDICATOR] - 1;
   }
   return 0;
}

void fmu_release(fmu_variables *list)
{
   int i;
   for (i = 0; i < list->n; i++) {
      free(list->items[i].name);
      free(list->items[i].unit);
      free(list->items[i].description);
   }
   free(list->items);
   memset(list, 0, sizeof *list);
}
