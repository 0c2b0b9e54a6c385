// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.hpp"
#include "common/config/config.hpp"
#include "common/config/expression.hpp"
#include "structure_solver/elements/line.hpp"
#include "structure_solver/elements/membrane.hpp"
#include "structure_solver/elements/solid.hpp"
#include "structure_solver/length_schedule.hpp"

namespace drogue::structure {

struct MembraneSettings {
  std::string group;
  MembraneMaterial material;
};
struct SolidSettings {
  std::string group;
  SolidMaterial material;
};
struct LineSettings {
  std::string group;
  LineMaterial material;
  /// Empty: the length in the reference configuration.
  std::optional<double> natural_length;
};
struct MassSettings {
  std::string group;
  double mass = 0;
};
struct SupportSettings {
  std::string group;
  std::array<bool, 3> held{};
  config::VectorExpression displacement;
};
struct PressureSettings {
  std::string group;
  config::Expression value;
};
/// A traction on a surface group, or a force on every node of a group.
struct VectorLoadSettings {
  std::string group;
  config::VectorExpression value;
};
/// k |w| w on points, or on lines per length.
struct DragSettings {
  std::string group;
  double k = 0; ///< 1/2 rho C_d A of a point, 1/2 rho C_d d of a line
  config::VectorExpression air_velocity;
  bool cross_flow = false;
};
struct NaturalLengthSettings {
  std::string group;
  LengthSchedule schedule;
};
struct ProbeSettings {
  std::string name;
  std::array<double, 3> position{};
};

enum class TimeMode { dynamic, static_by_damped_dynamics, static_by_newton };
enum class TimeScheme { generalised_alpha, hht, newmark };

struct TimeSettings {
  TimeMode mode = TimeMode::dynamic;
  double step = 0.01;
  int steps = 100;
  double rho_infinity = 0.5;
  double mass_damping = 0;
  double largest_step = 0.1;
  double largest_time = 100;
  double unbalance = 2.5e-3;
  bool balanced_start = false;
  TimeScheme scheme = TimeScheme::generalised_alpha;
  double hht_alpha = -0.05;
  double newmark_beta = 0.25, newmark_gamma = 0.5;
  double stiffness_damping = 0;
  int max_halvings = 8;
  bool ramp_loads = true;
};

struct NewtonSettings {
  double displacement_tolerance = 1e-6;
  double residual_tolerance = 1e-9;
  int max_iterations = 20;
  int iterations_per_coupling = 0; ///< 0: to the tolerance
  bool load_stiffness = false;
};

struct OutputSettings {
  std::filesystem::path directory = "results";
  int field_interval = 10;
  int series_interval = 1;
};

/// A config of structure_solver, read and checked against its schema. proto/drogue/v1/structure.proto says
/// what each value means. File names are resolved.
struct LineForceSettings {
  std::string name;
  std::string group; ///< of lines
  std::string at;    ///< of the nodes they pull at
};

struct Settings {
  std::filesystem::path mesh;
  std::optional<std::filesystem::path> initial_state;
  bool initial_at_rest = false;
  std::optional<std::filesystem::path> final_state;
  bool plane = false;
  std::vector<MembraneSettings> membranes;
  std::vector<SolidSettings> solids;
  std::vector<LineSettings> cables;
  std::vector<LineSettings> trusses;
  std::vector<MassSettings> masses;
  std::vector<std::string> ignored_groups;
  std::vector<SupportSettings> supports;
  std::vector<PressureSettings> pressures;
  std::vector<VectorLoadSettings> tractions;
  std::vector<VectorLoadSettings> forces;
  config::VectorExpression gravity;
  std::vector<DragSettings> point_drag;
  std::vector<DragSettings> line_drag;
  std::vector<NaturalLengthSettings> natural_lengths;
  std::optional<config::VectorExpression> initial_velocity;
  TimeSettings time;
  NewtonSettings newton;
  std::string interface;
  int parts = 1;                 ///< steps of its own within a step of the coupling
  bool quadratic_inputs = false; ///< over these parts; else linear
  int threads = 0;               ///< of the assembly; 0: one for each processor, or OMP_NUM_THREADS
  OutputSettings output;
  std::vector<ProbeSettings> probes;
  std::vector<LineForceSettings> line_forces;
  /// Where each field stands, for errors that only the mesh can tell.
  config::Source source;
};

/// Reads a config; every error lands in `report`, and what could be read is returned in any case.
[[nodiscard]] Settings load_settings(const std::filesystem::path& file, config::Report& report);

} // namespace drogue::structure
