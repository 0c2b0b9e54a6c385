// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/config/config.hpp"
#include "common/config/expression.hpp"
#include "common/la_krylov/krylov_solver.hpp"

namespace drogue::fluid {

enum class Formulation { semi_discrete, dsd_sst };
enum class InterfaceLoad { pressure, traction, consistent_traction };
/// automatic: direct on one rank up to a size.
enum class LinearMethod { automatic, direct, krylov };
enum class Condition { velocity, no_slip, free_slip, traction_free, traction };

struct BoundarySettings {
  std::string name;
  Condition condition = Condition::no_slip;
  config::VectorExpression value;                   ///< velocity or traction
  std::array<bool, 3> components{true, true, true}; ///< of no_slip
  double backflow = 0;                              ///< of traction_free
  bool slip_wall = false;                           ///< of free_slip: its motion pushes the fluid

  /// The flow may cross it freely: its normal velocity is not prescribed by kind.
  [[nodiscard]] bool is_open() const {
    return condition == Condition::traction_free || condition == Condition::traction;
  }
};

struct PhaseSettings {
  Formulation formulation = Formulation::dsd_sst;
  double step = 0;
  int steps = 0;
  std::optional<config::VectorExpression> mesh_displacement;
  int time_order = 1;  ///< of semi_discrete
  int time_points = 2; ///< quadrature points of dsd_sst
  double steady_tolerance = 0;
};

struct NewtonSettings {
  double residual_tolerance = 0;
  int max_iterations = 0;
  double failure_tolerance = 0;
  int iterations_per_coupling = 0;
  int jacobian_lag = 0;
  bool picard = false;
  double shortest_correction = 1;
  int max_halvings = 0;
};

/// What a mesh must keep, else it is replaced.
struct RemeshSettings {
  double mean_ratio = 0;
  double angle = 0; ///< dihedral [degrees]
};

struct ForceSettings {
  std::string name;
  std::vector<std::string> boundaries;
  /// 1/2 rho U^2 A; 0: no coefficient
  double reference_force = 0;
  std::array<double, 3> moment_about{};
};

struct ProbeSettings {
  std::string name;
  std::array<double, 3> position{};
};

struct OutputSettings {
  std::filesystem::path directory;
  int field_interval = 0;
  int series_interval = 1;
};

/// A validated config. Names of groups are checked against the mesh by check_against_mesh
/// (boundary_conditions.hpp).
struct Settings {
  config::Source source;
  std::filesystem::path mesh;
  std::optional<std::filesystem::path> initial_state;
  std::optional<std::filesystem::path> initial_state_mesh; ///< where the state lives on another mesh
  std::optional<std::filesystem::path> final_state;
  config::VectorExpression initial_velocity;
  config::Expression initial_pressure;
  bool project_initial_flow = false;
  double density = 0;
  double dynamic_viscosity = 0;
  double smagorinsky = 0;
  bool lsic = true;
  std::optional<double> tau_step; ///< in place of the step in tau
  bool time_weight = true;        ///< DSD/SST's test functions weigh by their time derivative
  bool viscous_residual = false;  ///< recovered viscous force in the stabilisation's residual
  config::VectorExpression body_force;
  std::vector<PhaseSettings> phases;
  std::optional<RemeshSettings> remesh; ///< stand-alone
  NewtonSettings newton;
  LinearMethod linear_method = LinearMethod::automatic;
  la::KrylovOptions linear;
  std::vector<BoundarySettings> boundaries;
  double slip_feature_angle = 40; ///< [degrees]
  std::vector<std::string> interface;
  InterfaceLoad interface_load = InterfaceLoad::pressure;
  std::vector<ForceSettings> forces;
  OutputSettings output;
  std::vector<ProbeSettings> probes;
  std::optional<double> average_from; ///< time
  /// Paths of the fields given in the config that a coupled run does not use.
  std::vector<std::string> alone_only;

  [[nodiscard]] double kinematic_viscosity() const { return dynamic_viscosity / density; }
};

/// Loads and checks everything that needs no mesh; what is wrong lands in `report`.
[[nodiscard]] Settings load_settings(const std::filesystem::path& file, config::Report& report);

} // namespace drogue::fluid
