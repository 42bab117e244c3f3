/* Rows and events of a scene through the C interface, as numbers, for a comparison bit for bit.
 *
 *   rows SCENE STEPS [SETTING...]    goes to the end in STEPS advances
 * writes for each row an "r" and the values of all quantities, for each event an "e", its time,
 * kind and contact; what they are called goes before, a line for each. */
#include <contensou.h>
#include <stdio.h>
#include <stdlib.h>

static contensou_simulation *simulation;
static double *values;

static int row(double time, const double *state, int n, void *user_data)
{
   contensou_error *error;
   int i;
   (void)time, (void)state, (void)n, (void)user_data;

   putchar('r');
   for (i = 0; i < contensou_simulation_quantities(simulation); i++) {
      contensou_quantity quantity;
      contensou_simulation_quantity(simulation, i, &quantity);
      if (contensou_simulation_values(simulation, quantity.name, values, quantity.size, &error))
         return 1;
      fwrite(values, sizeof *values, (size_t)quantity.size, stdout);
   }
   return 0;
}

static int event(double time, int kind, int contact, void *user_data)
{
   const double what[] = {time, kind, contact};
   (void)user_data;
   putchar('e');
   fwrite(what, sizeof *what, 3, stdout);
   return 0;
}

int main(int argc, char **argv)
{
   contensou_error *error;
   int i, size = 0, status = 0, steps;
   double end;

   if (argc < 3) return 64;
   steps = atoi(argv[2]);
   simulation = contensou_simulation_new(argv[1], (const char *const *)argv + 3, argc - 3, &error);
   for (i = 0; i < contensou_simulation_quantities(simulation); i++) {
      contensou_quantity quantity;
      contensou_simulation_quantity(simulation, i, &quantity);
      printf("%s %d\n", quantity.name, quantity.size);
      size += quantity.size;
   }
   puts("");
   values = malloc((size_t)size * sizeof *values);
   contensou_simulation_observe(simulation, row, event, NULL);
   end = contensou_simulation_end(simulation);
   for (i = 1; simulation && i <= steps && status == 0; i++)
      status = contensou_simulation_advance(simulation, i < steps ? end * i / steps : end, &error);
   if (error) fprintf(stderr, "%s\n", contensou_error_message(error));
   status = contensou_error_status(error);
   contensou_error_free(error);
   contensou_simulation_free(simulation);
   free(values);
   return status;
}
