// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>

#include "common/base/result.hpp"
#include "common/base/role.hpp"

namespace drogue {

/// What one of our solvers does with its command line. The functions print their own results; errors are
/// returned.
struct SolverProgram {
  std::string name;
  std::string description;
  /// `NAME check FILE`: validates a config; for a coupled run with `--participant`, or when the environment
  /// holds DROGUE_PARTICIPANT, as the coupler's checks do.
  std::function<Result<void>(const std::string& file, Role role)> check;
  /// SIGINT and SIGTERM are caught (common/base/interrupt.hpp): the run ends itself, in order.
  /// `NAME run FILE`: alone when `endpoint` is empty; `NAME run FILE --connect ENDPOINT`: as a participant.
  std::function<Result<void>(const std::string& file, const std::string& endpoint)> run;
  /// `NAME remesh FROM TO`: meshes the volume of a mesh anew inside its boundary (common/meshing/remesh.hpp);
  /// empty: there is no such command.
  std::function<Result<void>(const std::string& from, const std::string& to)> remesh = {};
  /// Whether this process prints errors: one rank of an MPI job does.
  std::function<bool()> speaks = [] { return true; };
};

/// The whole of main(): parses the command line, starts the log, runs, prints an error. Returns the exit
/// status (0 done, 1 internal, 2 bad config or command line, 3 numerical failure, 4 peer, 5 interrupted).
[[nodiscard]] int run_solver_program(const SolverProgram& program, int argc, char** argv);

} // namespace drogue
