// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "common/config/config.hpp"
#include "common/config/expression.hpp"
#include "coupler/acceleration/accelerator.hpp"
#include "coupler/projection/interface_quadrature.hpp"

namespace drogue::coupler {

enum class NonConvergence { abort, accept, retry };
enum class WallVelocity { structure_rate, mesh_rate };
enum class LoadTime { matching, end_of_step, mean_of_step, extrapolated_mean };
enum class Scheme { serial, parallel, structure_first };

struct ParticipantSettings {
  std::string name;             ///< "fluid", "mesh_mover", and "structure" or what the case calls it
  std::string path;             ///< in the case: "fluid", "structure[0]"
  std::string command;          ///< as written in the case
  std::string command_position; ///< file:line:column of it
  std::vector<std::string> arguments;
  std::filesystem::path config; ///< empty for a participant with arguments of its own
  int ranks = 1;
  std::vector<std::string> environment;
  bool by_hand = false;             ///< somebody else starts it
  std::filesystem::path public_key; ///< file; empty: none
  std::filesystem::path directory;  ///< by hand: for its results, on its machine; empty: RUN/NAME
};

/// Where participants that are started by hand connect.
struct NetworkSettings {
  std::string endpoint;
  std::string connect;       ///< empty: the endpoint
  std::filesystem::path key; ///< file; empty: none
};

struct LoopSettings {
  double relative = 1e-3;
  double absolute = 0;
  double floor = 1e-9;
  int max_iterations = 40;
  int min_iterations = 1;
  int predictor = 1;
  NonConvergence non_convergence = NonConvergence::abort;
  int max_halvings = 4;
  double divergence = 1e6;
  WallVelocity wall_velocity = WallVelocity::structure_rate;
  double inner_residual = 0.1;
  LoadTime load = LoadTime::matching;
  Scheme scheme = Scheme::serial;
  double residual_relative = 0, velocity_relative = 0, load_relative = 0; ///< 0: not asked
  int stall = 15;                                                         ///< 0: never
};

/// Seconds.
struct DeadlineSettings {
  double connect = 60;
  double initialize = 600;
  double iterate = 600;
  double other = 120;
  double shutdown = 10;
  double by_hand = 3600;
};

/// When checkpoints are written; 0: not for that reason.
struct CheckpointSettings {
  int steps = 0;
  double time = 0;
  double wall_clock = 0; ///< seconds
  int keep = 2;
  [[nodiscard]] bool asked() const { return steps > 0 || time > 0 || wall_clock > 0; }
};

/// A whole case, checked. Meaning, dimension and range of every value: proto/drogue/v1/coupler.proto.
struct CaseSettings {
  std::filesystem::path file;
  std::string name;
  std::filesystem::path run_directory;
  ParticipantSettings fluid, mesh_mover;
  std::vector<ParticipantSettings> structures; ///< at least one
  double time_step = 0;
  int steps = 0;
  LoopSettings loop;
  acceleration::Settings acceleration;
  projection::Settings projection;
  DeadlineSettings deadlines;
  CheckpointSettings checkpoints;
  NetworkSettings network;
  int restarts = 0; ///< after the death or silence of a participant, at most
  config::Expression load_factor;
  config::Expression withheld_first_load;
  bool outer_boundary_follows = true;
  std::filesystem::path start_from;     ///< folder of a run, absolute; empty: from the solvers' own start
  std::array<double, 3> drag_weights{}; ///< cd = weights . F; zero without a reference
  std::string hash;                     ///< of all that changes results, see CheckpointManifest.case_file
};

/// All participants; pointers into the settings.
[[nodiscard]] std::vector<const ParticipantSettings*> participants_of(const CaseSettings& settings);

/// Reads and checks a case file. All errors land in `report`; what could be read is returned in any case.
[[nodiscard]] CaseSettings load_case(const std::filesystem::path& file, config::Report& report);

} // namespace drogue::coupler
