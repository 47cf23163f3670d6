/* Runs a solver of Siconos on a .lcp file:
   `siconos_lcp FILE lemke|newton OUT.res REPETITIONS SECONDS`; no problem is begun after so many
   seconds. The answer has the format of `stickslip lcp --out`. */
#include <LinearComplementarityProblem.h>
#include <NonSmoothDrivers.h>
#include <NumericsMatrix.h>
#include <SolverOptions.h>
#include <lcp_cst.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static double now_us(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return 1e6 * (double)t.tv_sec + 1e-3 * (double)t.tv_nsec;
}

int main(int argc, char **argv) {
  if (argc != 6) return 2;
  double patience_us = 1e6 * atof(argv[5]), began = now_us();
  FILE *in = fopen(argv[1], "rb"), *out = fopen(argv[3], "wb");
  int32_t head[6], repetitions = atoi(argv[4]);
  if (!in || !out || fread(head, 4, 6, in) != 6 || head[0] != 0x4c435031) return 1;
  int number = head[1], n = head[2];
  int solver = strcmp(argv[2], "lemke") ? SICONOS_LCP_NEWTON_MIN_FBLSA : SICONOS_LCP_LEMKE;
  if (!strcmp(argv[2], "newton")) solver = SICONOS_LCP_NEWTON_FB_FBLSA;
  double *rows = malloc(sizeof(double) * n * n), *columns = malloc(sizeof(double) * n * n);
  double *q = malloc(sizeof(double) * n), *z = malloc(sizeof(double) * n), *w = malloc(sizeof(double) * n);
  int32_t top[2] = {number, n};
  fwrite(top, 4, 2, out);
  int done = 0;
  for (int k = 0; k < number && now_us() - began < patience_us; k++, done++) {
    if (fread(rows, 8, (size_t)n * n, in) != (size_t)n * n || fread(q, 8, n, in) != (size_t)n) return 1;
    double times[64];
    int info = 1, pivots = 0, made = 0;
    for (int r = 0; r < repetitions && r < 64; r++, made++) {
      /* A slow solve is not repeated. */
      if (r > 0 && times[0] > 2e4) break;
      for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) columns[j * n + i] = rows[i * n + j];
      NumericsMatrix *m = NM_create_from_data(NM_DENSE, n, n, columns);
      LinearComplementarityProblem problem = {n, m, q};
      SolverOptions *options = solver_options_create(solver);
      options->dparam[SICONOS_DPARAM_TOL] = 1e-12;
      options->iparam[SICONOS_IPARAM_MAX_ITER] = 10000;
      memset(z, 0, sizeof(double) * n);
      memset(w, 0, sizeof(double) * n);
      double start = now_us();
      info = linearComplementarity_driver(&problem, z, w, options);
      times[r] = now_us() - start;
      pivots = options->iparam[SICONOS_IPARAM_ITER_DONE];
      solver_options_delete(options);
      m->matrix0 = NULL;
      NM_clear(m);
      free(m);
    }
    int32_t line[4] = {info != 0, pivots, made, 0};
    fwrite(line, 4, 4, out);
    fwrite(times, 8, made, out);
    fwrite(z, 8, n, out);
  }
  /* As many as were reached. */
  top[0] = done;
  if (fseek(out, 0, SEEK_SET) || fwrite(top, 4, 2, out) != 2) return 1;
  return fclose(out) != 0;
}
