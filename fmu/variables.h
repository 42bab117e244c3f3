/* The variables of an FMU of a scene: the same list for the program that describes them and for the
 * FMU that answers for them. */
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
   int object;     /* number of the body of an input, of the quantity of an output */
   int place;      /* number among those of its kind and object: the component */
} fmu_variable;

typedef struct {
   fmu_variable *items;
   int n;
   int first[7], count[7]; /* of each kind */
} fmu_variables;

/* List the variables of a simulation at its beginning, with the work of loads in its state. Returns
 * 0, or -1 where there is no memory. */
int fmu_list(contensou_simulation *simulation, fmu_variables *list);

/* Let all bodies that move freely take loads, so that their work is in the state. */
int fmu_take_loads(contensou_simulation *simulation, contensou_error **error);

void fmu_release(fmu_variables *list);

#endif
