/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DROGUE_PARTICIPANT_H
#define DROGUE_PARTICIPANT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define DROGUE_API __attribute__((visibility("default")))
#else
#define DROGUE_API
#endif

/**
 * @file
 * The SDK of a Drogue participant for C, and for whatever calls C (Fortran with iso_c_binding). Fill in a
 * drogue_solver and call drogue_serve(): it talks to the coupler (docs/protocol.md) and calls your functions from
 * one thread, in this order:
 *
 *     drogue_serve ---> configure ---> initialize ---> READY
 *
 *     READY ---> begin_step ---> iterate ---> iterate ---> ... ---> commit ---> READY
 *                     |             |            |
 *                     +-------------+------------+---> rollback ---> READY
 *     READY ---> checkpoint ---> READY
 *     READY ---> restore    ---> READY
 *
 * The end may come between any two calls: Shutdown and Abort of the coupler, or its death. drogue_serve() then
 * returns. Requests out of order never reach your functions.
 *
 * Strings and arrays that a function gets are valid until it returns. Those that it gives (drogue_interface) must be
 * valid until drogue_serve() calls the next function: they are copied. Fields are row-major, {nodes, components}.
 * Nothing here is thread-safe but drogue_progress().
 */

/** What a function returns; DROGUE_OK to DROGUE_INTERRUPTED are also the exit statuses of a participant. */
enum drogue_status {
  DROGUE_OK = 0,
  DROGUE_INTERNAL = 1,    /**< anything else; ends the participant */
  DROGUE_CONFIG = 2,      /**< its configuration or files are wrong; ends it */
  DROGUE_NUMERICAL = 3,   /**< a numerical failure; ends it */
  DROGUE_PEER = 4,        /**< from drogue_serve() alone: the coupler is gone, silent, or aborted the run */
  DROGUE_INTERRUPTED = 5, /**< from drogue_serve() alone */
  DROGUE_RETRY = 6        /**< a numerical failure that a smaller step may cure: the solver is ready for rollback */
};

/** Numbers as in proto/drogue/v1/wire.proto, which says what they mean. */
enum drogue_quantity {
  DROGUE_DISPLACEMENT = 1, /**< since initialize [length] */
  DROGUE_VELOCITY = 2,     /**< [length/time] */
  DROGUE_FORCE = 3,        /**< nodal force on the structure [force] */
  DROGUE_PRESSURE = 4,     /**< of the fluid on the wall, positive in compression [stress] */
  DROGUE_TRACTION = 5,     /**< of the fluid on the wall, per current area [stress] */
  DROGUE_TRANSLATION = 6,  /**< of the outer boundary [length] */
  DROGUE_QUALITY = 7
};
enum drogue_location { DROGUE_INTERFACE_NODES = 1, DROGUE_MESH_NODES = 2, DROGUE_GLOBAL = 3 };
enum drogue_time_level { DROGUE_END_OF_STEP = 1, DROGUE_MEAN_OF_STEP = 2 };

/** A field that is taken in iterate, or given. The names of each role stand in docs/protocol.md. */
typedef struct drogue_field {
  const char* name;
  int quantity;   /**< drogue_quantity */
  int location;   /**< drogue_location */
  int components; /**< 1 or 3 */
  int time_level; /**< drogue_time_level */
  int optional;   /**< an input that may be absent, an output that may be left out */
} drogue_field;

enum drogue_element {
  DROGUE_LINES = 0, /**< 2 nodes: the interface of a plane problem */
  DROGUE_LINES3,    /**< 3 */
  DROGUE_TRIANGLES, /**< 3 */
  DROGUE_TRIANGLES6,
  DROGUE_QUADRANGLES4,
  DROGUE_QUADRANGLES9
};

/** Elements of one kind: {count, nodes of the element} indices into the points, nodes in Gmsh's order. */
typedef struct drogue_elements {
  int kind; /**< drogue_element */
  size_t count;
  const int64_t* nodes;
} drogue_elements;

/** The surface that exchanges. On a fluid its normal points out of the fluid, into the wall; that of a line lies to
 * the right of its direction. Pointers that say optional may be NULL; all is zero before initialize is called. */
typedef struct drogue_interface {
  size_t node_count;
  const double* points;    /**< {node_count, 3}: positions now */
  const double* reference; /**< {node_count, 3}, optional: unstressed positions */
  const double* material;  /**< {node_count, 3}, optional: coordinates in which surfaces are matched */
  const double* velocity;  /**< {node_count, 3}, optional: of a structure that does not start at rest */
  size_t block_count;
  const drogue_elements* blocks;
  const int64_t* mesh_nodes; /**< {node_count}, optional: index of each node in the whole mesh (fluid, mesh_mover) */
  uint64_t mesh_node_count;  /**< nodes of the whole mesh */
  const char* mesh_hash;     /**< optional: identity of the whole mesh; fluid and mesh_mover must show the same */
} drogue_interface;

typedef struct drogue_run {
  const char* directory; /**< for results, absolute */
  double start_time;
  double time_step;
  int resume; /**< the directory holds the results of the part that was done before: they stay; restore follows */
} drogue_run;

typedef struct drogue_step {
  uint64_t step;    /**< from 1 */
  uint32_t attempt; /**< from 1, rises with every retry */
  double time;      /**< t_n */
  double time_step;
} drogue_step;

/** What an iterate did inside; the defaults are those of a solver that does not iterate itself. */
typedef struct drogue_report {
  uint32_t inner_iterations; /**< default 0 */
  double inner_residual;     /**< relative to the first of the step; default 0 */
  int converged;             /**< default 1 */
  int fixed_iterations;      /**< a fixed number in each call: the coupler judges inner_residual; default 0 */
} drogue_report;

/** The call under way: what it takes and gives. Valid until the function returns. */
typedef struct drogue_call drogue_call;

/** A solver: what it is, and what it does. Functions return a drogue_status; those that say optional may be NULL.
 *
 * Contract: iterate is deterministic: from the same begin_step state, the same sequence of inputs gives the same
 * sequence of outputs to the bit. */
typedef struct drogue_solver {
  const char* software; /**< free text for the log, e.g. "my_solver 1.2" */
  int can_rollback;
  int can_checkpoint;
  int variable_step; /**< steps of any length may follow one another */
  const drogue_field* inputs;
  size_t input_count;
  const drogue_field* outputs;
  size_t output_count;
  void* user; /**< first argument of every function */

  /** Optional. @pre called once, first  @post results go into run->directory */
  int (*configure)(void* user, const drogue_run* run, drogue_call* call);
  /** Reads meshes and states. @pre after configure, once  @post *interface is filled in, ready for begin_step */
  int (*initialize)(void* user, drogue_interface* interface, drogue_call* call);
  /** Saves what rollback needs. @pre READY  @post in the step, whose length is step->time_step */
  int (*begin_step)(void* user, const drogue_step* step, drogue_call* call);
  /** One solve to t_{n+1}. @pre in the step; every required input is there, of the contract's shape, and finite
   * @post every output that is not optional was asked for with drogue_output() and filled in, with finite values */
  int (*iterate)(void* user, drogue_call* call, drogue_report* report);
  /** @pre after an iterate  @post its result is the state at t_{n+1}; results are written if write_output and the
   * solver's own interval say so */
  int (*commit)(void* user, int write_output, drogue_call* call);
  /** Optional without can_rollback. @pre in the step  @post exactly the state at begin_step */
  int (*rollback)(void* user, drogue_call* call);
  /** Optional without can_checkpoint. @pre READY; directory exists, is empty and the solver's own  @post it holds, in
   * files of any names, what the steps to come depend on; the solver's state has not changed */
  int (*checkpoint)(void* user, const char* directory, drogue_call* call);
  /** Optional without can_checkpoint. @pre READY; checkpoint wrote this directory  @post exactly that state; in a
   * resumed run series of results are cut to their length then */
  int (*restore)(void* user, const char* directory, drogue_call* call);
} drogue_solver;

/** Connects to the coupler and serves until the run ends. Which participant this is, the run, deadlines and keys come
 * from the environment that the coupler sets or prints (DROGUE_...). Waiting is passive.
 * @return DROGUE_OK after Shutdown, else what the program should exit with; the reason went to standard error. */
DROGUE_API int drogue_serve(const drogue_solver* solver, const char* endpoint);

/** What follows "--connect" among the arguments of main(); NULL when it is not there. */
DROGUE_API const char* drogue_endpoint(int argc, char** argv);

/** The values of an input {nodes, components}; NULL for an optional one that was not sent. @pre in iterate */
DROGUE_API const double* drogue_input(const drogue_call* call, const char* name);

/** Where the values of an output go, {nodes, components} zeros at first; NULL when the contract has no such output.
 * @pre in iterate */
DROGUE_API double* drogue_output(drogue_call* call, const char* name);

/** Says what went wrong, for a function that then returns another status than DROGUE_OK. */
DROGUE_API void drogue_explain(drogue_call* call, const char* text);

/** What the solver does, for signs of life: from any place, at any rate. `phase` must be a string literal. */
DROGUE_API void drogue_progress(const char* phase, uint32_t inner_iteration, double inner_residual);

#ifdef __cplusplus
}
#endif

#endif
