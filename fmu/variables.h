/* The variables of an FMU of a scene or of a contact: the same list for the program that describes
 * them and for the FMU that answers for them. */
#ifndef CONTENSOU_FMU_VARIABLES_H
#define CONTENSOU_FMU_VARIABLES_H

#include <contensou.h>

enum { FMU_TIME, FMU_PARAMETER, FMU_INPUT, FMU_OUTPUT, FMU_STATE, FMU_RATE, FMU_INDICATOR };

/* A variable; its value reference is its position in the list. */
typedef struct {
   int kind;
   char *name, *unit, *description;
   double start;
   int is_integer; /* a parameter that takes whole numbers only */
   int object;     /* number of the body of an input, of the quantity of an output, or FMU_ON_* */
   int place;      /* number among those of its kind and object: the component */
} fmu_variable;

typedef struct {
   fmu_variable *items;
   int n;
   int first[7], count[7]; /* of each kind */
} fmu_variables;

/* What a contact does to body A and body B: instead of the number of a quantity. */
enum { FMU_ON_A = -1, FMU_ON_B = -2 };

/* List the variables of a simulation at its beginning, with the work of loads in its state, or of
 * one of its contacts alone unless that is negative. Returns 0, or -1 where there is no memory. */
int fmu_list(contensou_simulation *simulation, int contact, fmu_variables *list);

/* Turn a vector from the axes of a body with an attitude to the inertial frame, or back. */
void fmu_turn(const double quaternion[4], int back, const double vector[3], double turned[3]);

/* The number of a contact by its name; -1 if there is none. */
int fmu_contact_of(const contensou_simulation *simulation, const char *name);

/* Let all bodies that move freely take loads, so that their work is in the state. */
int fmu_take_loads(contensou_simulation *simulation, contensou_error **error);

void fmu_release(fmu_variables *list);

#endif
