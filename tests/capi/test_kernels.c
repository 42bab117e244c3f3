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

/* Arrays by strides: forwards, repeated, backwards; elements and their order. */
static void check_arrays(const contensou_friction *friction)
{
   const double pi = 3.14159265358979323846;
   const double loads[] = {-1.0, 5.0, 0.0, 10.0}, axes[] = {1e-3, 0.5e-3}, speeds[] = {0.1, 0.2};
   const double *in[6] = {&loads[3], &axes[0], &axes[1], &speeds[0], &speeds[1], &speeds[0]};
   const ptrdiff_t strides[6] = {-2, 0, 0, 1, -1, 0};
   double wrenches[6], alone[3], slopes[30], one[15], up[3], down[3], K[3], E[3];
   const double c1[] = {1.0, 9.0, 0.5, 9.0, -1.0}, *complements[] = {c1};
   double *const integrals[] = {K, E};
   double *nowhere[] = {K, NULL};
   double x[] = {5.0, 1e-3, 0.5e-3, 0.2, 0.1, 0.1};
   int i, k;

   check(contensou_friction_wrench_array(friction, 2, in, strides, wrenches) == CONTENSOU_OK,
         "wrenches of an array");
   check(contensou_friction_jacobian_array(friction, 2, in, strides, wrenches, slopes) ==
            CONTENSOU_OK, "wrenches of an array with derivatives");
   for (i = 0; i < 2; i++) {
      contensou_friction_jacobian(friction, loads[3 - 2 * i], axes[0], axes[1], speeds[i],
                                  speeds[1 - i], speeds[0], alone, one);
      for (k = 0; k < 3; k++) check(alone[k] == wrenches[3 * i + k], "the wrench of one spot");
      for (k = 0; k < 15; k++) check(one[k] == slopes[15 * i + k], "the derivatives of one spot");
   }
   /* By differences: load, size at constant ratio of the axes, velocities, spin. */
   for (i = 0; i < 5; i++) {
      double *vary[5] = {&x[0], &x[1], &x[3], &x[4], &x[5]}, before = *vary[i], b = x[2];
      double h = 1e-5 * before;
      *vary[i] = before + h;
      if (i == 1) x[2] = x[1] / 2.0;
      contensou_friction_wrench(friction, x[0], x[1], x[2], x[3], x[4], x[5], up);
      *vary[i] = before - h;
      if (i == 1) x[2] = x[1] / 2.0;
      contensou_friction_wrench(friction, x[0], x[1], x[2], x[3], x[4], x[5], down);
      *vary[i] = before;
      x[2] = b;
      for (k = 0; k < 3; k++)
         check(fabs((up[k] - down[k]) / (2.0 * h) - one[5 * k + i]) <=
                  1e-8 * (fabs(one[5 * k + i]) + fabs(alone[k] / before)), "a derivative");
   }
   check(contensou_elliptic_array(3, complements, (const ptrdiff_t[]){2}, integrals) ==
            CONTENSOU_OK && fabs(K[0] - pi / 2.0) < 1e-15 && fabs(E[0] - pi / 2.0) < 1e-15 &&
            fabs(K[1] - 1.8540746773013719) < 1e-15 && isnan(K[2]) && isnan(E[2]),
         "elliptic integrals of an array");

   check(contensou_friction_wrench_array(NULL, 2, in, strides, wrenches) ==
            CONTENSOU_BAD_ARGUMENT, "no model");
   check(contensou_friction_wrench_array(friction, 2, NULL, strides, wrenches) ==
            CONTENSOU_BAD_ARGUMENT, "no inputs");
   check(contensou_friction_wrench_array(friction, 2, in, NULL, wrenches) ==
            CONTENSOU_BAD_ARGUMENT, "no strides");
   check(contensou_friction_jacobian_array(friction, 2, in, strides, wrenches, NULL) ==
            CONTENSOU_BAD_ARGUMENT, "nowhere to put derivatives");
   check(contensou_friction_wrench_array(friction, -1, in, strides, wrenches) ==
            CONTENSOU_BAD_ARGUMENT, "fewer than none");
   check(contensou_friction_wrench_array(friction, 0, NULL, NULL, NULL) == CONTENSOU_OK, "none");
   check(contensou_elliptic_array(3, complements, (const ptrdiff_t[]){2}, nowhere) ==
            CONTENSOU_BAD_ARGUMENT, "nowhere to put an output");
   in[2] = NULL;
   check(contensou_friction_wrench_array(friction, 2, in, strides, wrenches) ==
            CONTENSOU_BAD_ARGUMENT, "an input is missing");
}

/* Shear at constant load follows Cattaneo and Mindlin; a spot forgets when it opens. */
static void check_tangential(void)
{
   const double G = 8e10, nu = 0.3, a = 1e-4, limit = 3.0;
   double k[3], shift = 0.0, *stiffness[] = {k, k + 1, k + 2};
   const double *spot[] = {&a, &a, &G, &nu};
   const ptrdiff_t still[6] = {0}, strides[6] = {0, 0, 0, 1, 0, 0};
   enum { STEPS = 100 };
   double limits = limit, steps[STEPS], none = 0.0, out[5][STEPS], energy = 0.0;
   const double *in[] = {&limits, &a, &a, steps, &none, &none};
   double *const outputs[] = {out[0], out[1], out[2], out[3], out[4]};
   contensou_tangential *layered, *spring;
   int i;

   check(contensou_tangential_stiffness_array(1, spot, still, stiffness) == CONTENSOU_OK &&
            fabs(k[0] / (4.0 * G * a / (2.0 - nu)) - 1.0) < 1e-14 && k[0] == k[1] &&
            fabs(k[2] / (8.0 / 3.0 * G * a * a * a) - 1.0) < 1e-14, "stiffness of a circle");
   layered = contensou_tangential_new(G, nu, 64);
   spring = contensou_tangential_new(G, nu, 0);
   check(layered && spring, "spots");
   for (i = 0; i < STEPS; i++) steps[i] = 0.9 * 1.5 * limit / k[0] / STEPS;
   check(contensou_tangential_advance_array(layered, STEPS, in, strides, outputs) == CONTENSOU_OK,
         "steps");
   for (i = 0; i < STEPS; i++) {
      double share;
      shift += steps[i];
      share = 1.0 - k[0] * shift / (1.5 * limit);
      check(fabs(out[0][i] + limit * (1.0 - pow(share, 1.5))) < 2e-3 * limit,
            "the force of Cattaneo and Mindlin");
      check(out[1][i] == 0.0 && out[2][i] == 0.0 && out[3][i] > 0.0 && out[4][i] >= 0.0,
            "the rest of a step");
      energy += out[4][i] - 0.5 * (out[0][i] + (i ? out[0][i - 1] : 0.0)) * -steps[i];
   }
   check(fabs(energy + out[3][STEPS - 1]) < 1e-3 * out[3][STEPS - 1], "the balance of energy");
   contensou_tangential_advance_array(spring, STEPS, in, strides, outputs);
   check(fabs(out[0][0] + k[0] * steps[0]) < 1e-12 * limit && fabs(out[0][STEPS - 1] + limit) <
            1e-12 * limit, "one spring has one limit");
   limits = 0.0;
   contensou_tangential_advance_array(layered, 1, in, strides, outputs);
   check(out[0][0] == 0.0 && out[3][0] == 0.0 && out[4][0] > 0.0, "an open spot lets go");
   limits = NAN;
   check(contensou_tangential_advance_array(layered, 1, in, strides, outputs) == CONTENSOU_OK &&
            isnan(out[0][0]), "a limit that is no number");
   check(contensou_tangential_advance_array(NULL, 1, in, strides, outputs) ==
            CONTENSOU_BAD_ARGUMENT, "no spot");
   check(!contensou_tangential_new(-1.0, nu, 3) && !contensou_tangential_new(G, 0.6, 3) &&
            !contensou_tangential_new(NAN, nu, 3) && !contensou_tangential_new(G, nu, 129) &&
            !contensou_tangential_new(G, nu, -2),
         "spots out of the domain");
   contensou_tangential_free(layered);
   contensou_tangential_free(spring);
   contensou_tangential_free(NULL);
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
   check(contensou_friction_wrench(exact, 10.0, 1e-3, 1e-3, NAN, 1.0, 1.0, wrench) ==
            CONTENSOU_BAD_ARGUMENT && wrench[0] == 0.0, "a velocity that is no number");
   check(contensou_friction_wrench(exact, 10.0, 1e-3, 1e-3, 1.0, 1.0, 1.0, NULL) ==
            CONTENSOU_BAD_ARGUMENT, "nowhere to put a wrench");
   check(contensou_hertz(A, A, 5e9, 1e-7, NULL, NULL, &force, NULL) == CONTENSOU_OK && force > 0.0,
         "outputs that are not wanted");
   check_arrays(exact);
   check_tangential();
   contensou_friction_free(exact);
   contensou_friction_free(NULL);

   check(contensou_friction_new("no_such_model", 0.5, 0.0, true) == NULL, "unknown model");
   check(contensou_friction_new(NULL, 0.5, 0.0, true) == NULL, "a model without a name");
   check(contensou_friction_new("pade22", NAN, 0.0, true) == NULL, "a coefficient that is none");
   check(contensou_friction_new("none", 0.5, 0.0, true) == NULL, "the model none");
   check(contensou_friction_new("coulomb", 0.5, 0.0, true) == NULL, "coulomb without delta");
   check(contensou_friction_new("pade22", -0.5, 0.0, true) == NULL, "negative coefficient");

   printf("%d passed, %d failed\n", passed, failed);
   return failed > 0;
}
