/* The C interface, its failures included; prints one line for each failed check. */
#include <contensou.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static int passed, failed;

static void check(int condition, const char *name)
{
   if (condition) {
      passed++;
   } else {
      failed++;
      printf("failed: %s\n", name);
   }
}

int main(void)
{
   const double pi = 3.14159265358979323846;
   const double A = 1.0 / (2.0 * 0.015);
   double force, a, b, pressure, wrench[3];
   contensou_friction *exact;

   check(strchr(contensou_version(), '.') != NULL, "the version has a dot");

   check(contensou_hertz(A, A, 5e9, 1e-7, &a, &b, &force, &pressure) == CONTENSOU_OK,
         "Hertz contact of a sphere");
   check(fabs(force / (4.0 / 3.0 * 5e9 * sqrt(0.015) * pow(1e-7, 1.5)) - 1.0) < 1e-14,
         "normal force");
   check(fabs(a / sqrt(0.015 * 1e-7) - 1.0) < 1e-14 && a == b, "radius of the spot");
   check(fabs(pressure / (1.5 * force / (pi * a * b)) - 1.0) < 1e-14, "pressure");
   check(contensou_hertz(A, 4.0 * A, 5e9, 1e-7, &a, &b, &force, &pressure) == CONTENSOU_OK &&
            b < a && fabs(pressure / (1.5 * force / (pi * a * b)) - 1.0) < 1e-14,
         "elliptic contact");
   check(contensou_hertz(A, A, 5e9, 0.0, &a, &b, &force, &pressure) == CONTENSOU_OK &&
            force == 0.0 && a == 0.0 && pressure == 0.0, "no approach, no force");
   check(contensou_hertz(A, A, -1.0, 1e-7, &a, &b, &force, &pressure) == CONTENSOU_BAD_ARGUMENT,
         "negative modulus");
   check(contensou_hertz(2.0 * A, A, 5e9, 1e-7, &a, &b, &force, &pressure) ==
            CONTENSOU_BAD_ARGUMENT, "curvatures in the wrong order");
   check(contensou_hertz(A, A, 5e9, NAN, &a, &b, &force, &pressure) == CONTENSOU_BAD_ARGUMENT,
         "approach that is no number");

   exact = contensou_friction_new("contensou_exact", 0.5, 0.0, true);
   check(exact != NULL, "a model is made");
   check(contensou_friction_wrench(exact, 10.0, 1e-3, 1e-3, 0.0, 0.0, 2.0, wrench) == CONTENSOU_OK &&
            wrench[0] == 0.0 && wrench[1] == 0.0, "pure spin has no force");
   check(fabs(wrench[2] + 3.0 * pi / 16.0 * 0.5 * 10.0 * 1e-3) < 1e-17, "torque of pure spin");
   check(contensou_friction_wrench(exact, 10.0, 1e-3, 1e-3, 3.0, 4.0, 0.0, wrench) == CONTENSOU_OK &&
            fabs(wrench[0] + 3.0) < 1e-14 && fabs(wrench[1] + 4.0) < 1e-14 && wrench[2] == 0.0,
         "pure sliding is Coulomb's law");
   check(contensou_friction_wrench(exact, -1.0, 1e-3, 1e-3, 3.0, 4.0, 0.0, wrench) ==
            CONTENSOU_BAD_ARGUMENT, "negative load");
   check(contensou_friction_wrench(exact, 10.0, 1e-3, 5e-4, 0.0, 1.0, 1.0, wrench) ==
            CONTENSOU_OK && wrench[1] < 0.0 && wrench[2] < 0.0, "elliptic spot");
   check(contensou_friction_wrench(exact, 10.0, 1e-3, 2e-3, 0.0, 1.0, 1.0, wrench) ==
            CONTENSOU_BAD_ARGUMENT, "axes in the wrong order");
   check(contensou_friction_wrench(NULL, 1.0, 1e-3, 1e-3, 3.0, 4.0, 0.0, wrench) ==
            CONTENSOU_BAD_ARGUMENT, "no model");
   contensou_friction_free(exact);
   contensou_friction_free(NULL);

   check(contensou_friction_new("no_such_model", 0.5, 0.0, true) == NULL, "unknown model");
   check(contensou_friction_new("none", 0.5, 0.0, true) == NULL, "the model none");
   check(contensou_friction_new("coulomb", 0.5, 0.0, true) == NULL, "coulomb without delta");
   check(contensou_friction_new("pade22", -0.5, 0.0, true) == NULL, "negative coefficient");

   printf("%d passed, %d failed\n", passed, failed);
   return failed > 0;
}
