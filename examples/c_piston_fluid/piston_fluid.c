/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * A fluid in C that takes the place of Drogue's own: linear piston theory, for a wall that moves slowly against the
 * speed of sound c of a compressible fluid of density rho [lighthill1953]. Every point of the wall is the piston of a
 * long tube, and only radiates:
 *
 *     p = p_0 - rho c v.n     n: out of the fluid, into the wall; p_0: the pressure of the fluid at rest
 *
 * The wall is the rectangle (0, 0) to (size_x, size_y) at a height z, the fluid below it: n = (0, 0, 1) for small
 * motions. The same program is the mesh mover that goes with it: the fluid's mesh is the wall alone.
 *
 *     piston_fluid fluid      --impedance RHO_C [--pressure P_0] --size X Y --cells NX NY --height Z --connect ENDPOINT
 *     piston_fluid mesh_mover                                    --size X Y --cells NX NY --height Z --connect ENDPOINT
 */
#include <drogue_participant.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Wall {
  double impedance, pressure, size_x, size_y, height;
  size_t cells_x, cells_y, nodes;
  double* points;      /* {nodes, 3} */
  double* areas;       /* {nodes} */
  int64_t* triangles;  /* {2 cells, 3} */
  int64_t* mesh_nodes; /* {nodes} */
  drogue_elements block;

  double time_step;
  double power;            /* sent out through the wall in the last iterate */
  double energy, energy_n; /* sent out up to the last iterate, and up to t_n */
} Wall;

static int out_of_memory(drogue_call* call) {
  drogue_explain(call, "out of memory");
  return DROGUE_INTERNAL;
}

static void fill_points(Wall* w) {
  const size_t row = w->cells_x + 1;
  const double cell = w->size_x / (double)w->cells_x * w->size_y / (double)w->cells_y;
  for (size_t i = 0; i < w->nodes; ++i) {
    const size_t ix = i % row, iy = i / row;
    w->points[3 * i] = w->size_x * (double)ix / (double)w->cells_x;
    w->points[3 * i + 1] = w->size_y * (double)iy / (double)w->cells_y;
    w->points[3 * i + 2] = w->height;
    w->areas[i] = cell * (ix % w->cells_x ? 1 : 0.5) * (iy % w->cells_y ? 1 : 0.5);
    w->mesh_nodes[i] = (int64_t)i;
  }
}

static void fill_triangles(Wall* w) {
  const int64_t row = (int64_t)w->cells_x + 1;
  int64_t* t = w->triangles;
  for (int64_t j = 0; j < (int64_t)w->cells_y; ++j)
    for (int64_t i = 0; i < (int64_t)w->cells_x; ++i, t += 6) {
      const int64_t a = j * row + i; /* counterclockwise from above: the normal is (0, 0, 1) */
      const int64_t corners[6] = {a, a + 1, a + row + 1, a, a + row + 1, a + row};
      memcpy(t, corners, sizeof corners);
    }
}

static int initialize(void* user, drogue_interface* interface, drogue_call* call) {
  Wall* w = user;
  const size_t triangles = 2 * w->cells_x * w->cells_y;
  w->nodes = (w->cells_x + 1) * (w->cells_y + 1);
  w->points = malloc(3 * w->nodes * sizeof *w->points);
  w->areas = malloc(w->nodes * sizeof *w->areas);
  w->mesh_nodes = malloc(w->nodes * sizeof *w->mesh_nodes);
  w->triangles = malloc(3 * triangles * sizeof *w->triangles);
  if (!w->points || !w->areas || !w->mesh_nodes || !w->triangles) return out_of_memory(call);
  fill_points(w);
  fill_triangles(w);
  w->block = (drogue_elements){DROGUE_TRIANGLES, triangles, w->triangles};
  interface->node_count = w->nodes;
  interface->points = w->points;
  interface->blocks = &w->block;
  interface->block_count = 1;
  interface->mesh_nodes = w->mesh_nodes;
  interface->mesh_node_count = w->nodes;
  interface->mesh_hash = "piston";
  return DROGUE_OK;
}

static int begin_step(void* user, const drogue_step* step, drogue_call* call) {
  (void)call;
  ((Wall*)user)->time_step = step->time_step;
  return DROGUE_OK;
}

static int radiate(void* user, drogue_call* call, drogue_report* report) {
  Wall* w = user;
  const double* v = drogue_input(call, "velocity");
  double* p = drogue_output(call, "pressure");
  (void)report;
  w->power = 0;
  for (size_t i = 0; i < w->nodes; ++i) {
    p[i] = w->pressure - w->impedance * v[3 * i + 2];
    w->power += w->impedance * v[3 * i + 2] * v[3 * i + 2] * w->areas[i];
  }
  w->energy = w->energy_n + w->time_step * w->power;
  return DROGUE_OK;
}

static int move_mesh(void* user, drogue_call* call, drogue_report* report) {
  const Wall* w = user;
  (void)report;
  memcpy(drogue_output(call, "mesh_displacement"), drogue_input(call, "displacement"),
         3 * w->nodes * sizeof *w->points);
  return DROGUE_OK;
}

static int commit(void* user, int write_output, drogue_call* call) {
  Wall* w = user;
  (void)write_output, (void)call;
  w->energy_n = w->energy;
  return DROGUE_OK;
}

static int rollback(void* user, drogue_call* call) {
  Wall* w = user;
  (void)call;
  w->energy = w->energy_n;
  return DROGUE_OK;
}

/* The state is one number: it goes into a file as it is, so that it comes back to the bit. */
static FILE* open_state(const char* directory, const char* mode, drogue_call* call) {
  char name[4096];
  snprintf(name, sizeof name, "%s/energy", directory);
  FILE* file = fopen(name, mode);
  if (!file) drogue_explain(call, "cannot open the file of the state, DIRECTORY/energy");
  return file;
}

static int checkpoint(void* user, const char* directory, drogue_call* call) {
  const Wall* w = user;
  FILE* file = open_state(directory, "wb", call);
  if (!file) return DROGUE_INTERNAL;
  const size_t written = fwrite(&w->energy_n, sizeof w->energy_n, 1, file);
  return fclose(file) == 0 && written == 1 ? DROGUE_OK : DROGUE_INTERNAL;
}

static int restore(void* user, const char* directory, drogue_call* call) {
  Wall* w = user;
  FILE* file = open_state(directory, "rb", call);
  if (!file) return DROGUE_CONFIG;
  const size_t read = fread(&w->energy_n, sizeof w->energy_n, 1, file);
  fclose(file);
  w->energy = w->energy_n;
  return read == 1 ? DROGUE_OK : DROGUE_CONFIG;
}

static const drogue_field fluid_inputs[] = {
    {"mesh_displacement", DROGUE_DISPLACEMENT, DROGUE_MESH_NODES, 3, DROGUE_END_OF_STEP, 0},
    {"velocity", DROGUE_VELOCITY, DROGUE_INTERFACE_NODES, 3, DROGUE_END_OF_STEP, 0}};
static const drogue_field fluid_outputs[] = {
    {"pressure", DROGUE_PRESSURE, DROGUE_INTERFACE_NODES, 1, DROGUE_END_OF_STEP, 0}};
static const drogue_field mover_inputs[] = {
    {"displacement", DROGUE_DISPLACEMENT, DROGUE_INTERFACE_NODES, 3, DROGUE_END_OF_STEP, 0}};
static const drogue_field mover_outputs[] = {
    {"mesh_displacement", DROGUE_DISPLACEMENT, DROGUE_MESH_NODES, 3, DROGUE_END_OF_STEP, 0}};

/* False when the arguments make no wall. */
static int read_arguments(Wall* w, int argc, char** argv) {
  for (int i = 2; i + 1 < argc; ++i) {
    if (!strcmp(argv[i], "--impedance")) w->impedance = atof(argv[i + 1]);
    if (!strcmp(argv[i], "--pressure")) w->pressure = atof(argv[i + 1]);
    if (!strcmp(argv[i], "--height")) w->height = atof(argv[i + 1]);
    if (i + 2 >= argc) break;
    if (!strcmp(argv[i], "--size")) {
      w->size_x = atof(argv[i + 1]);
      w->size_y = atof(argv[i + 2]);
    } else if (!strcmp(argv[i], "--cells")) {
      w->cells_x = strtoul(argv[i + 1], NULL, 10);
      w->cells_y = strtoul(argv[i + 2], NULL, 10);
    }
  }
  return w->size_x > 0 && w->size_y > 0 && w->cells_x > 0 && w->cells_y > 0;
}

int main(int argc, char** argv) {
  Wall wall = {0};
  const int is_fluid = argc > 1 && !strcmp(argv[1], "fluid");
  const int is_mover = argc > 1 && !strcmp(argv[1], "mesh_mover");
  if (!(is_fluid || is_mover) || !read_arguments(&wall, argc, argv)) {
    fprintf(stderr, "usage: piston_fluid fluid|mesh_mover [--impedance RHO_C] [--pressure P_0] --size X Y "
                    "--cells NX NY [--height Z] --connect ENDPOINT\n");
    return DROGUE_CONFIG;
  }
  const drogue_solver solver = {
      .software = is_fluid ? "piston_fluid" : "piston_fluid mesh mover",
      .can_rollback = 1,
      .can_checkpoint = 1,
      .variable_step = 1,
      .inputs = is_fluid ? fluid_inputs : mover_inputs,
      .input_count = is_fluid ? 2 : 1,
      .outputs = is_fluid ? fluid_outputs : mover_outputs,
      .output_count = 1,
      .user = &wall,
      .initialize = initialize,
      .begin_step = begin_step,
      .iterate = is_fluid ? radiate : move_mesh,
      .commit = commit,
      .rollback = rollback,
      .checkpoint = checkpoint,
      .restore = restore,
  };
  const int status = drogue_serve(&solver, drogue_endpoint(argc, argv));
  if (is_fluid) printf("energy sent out: %.17g\n", wall.energy_n);
  free(wall.points);
  free(wall.areas);
  free(wall.mesh_nodes);
  free(wall.triangles);
  return status;
}
