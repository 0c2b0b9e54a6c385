// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.hpp"
#include "common/base/role.hpp"
#include "common/config/expression.hpp"
#include "common/mesh/mesh.hpp"
#include "mesh_mover/quality.hpp"

namespace drogue::mesh_mover {

/// What the stiffness of a step is taken from; see the config schema.
enum class Increment { from_last_step, from_initial };

/// How the boundary's motion is carried into the mesh.
enum class Method { elastic, algebraic };

enum class LinearSolverKind { automatic, direct, iterative };

/// Elements around the displaced boundaries, so many layers deep, are stiffer by a factor.
struct StiffLayers {
  int layers = 0;
  double factor = 1;
};

/// In the order of precedence where boundaries meet: an edge follows the first.
enum class Condition { displacement, fixed, translated, sliding };

struct Boundary {
  std::string name;
  Condition condition = Condition::fixed;
  /// Condition::displacement: since the start, of the initial position and time [length].
  config::VectorExpression displacement;
  /// Condition::sliding: axis normal to the plane (0, 1, 2).
  int normal = 0;
  /// Follows the coupler's displacement when run as a participant.
  bool is_interface = false;
};

struct OutputSettings {
  std::filesystem::path directory;
  int field_interval = 0;
  int series_interval = 1;
};

struct Settings {
  Method method = Method::elastic;
  double weight_exponent = 2; ///< Method::algebraic
  double stiffening_exponent = 1;
  double poisson_ratio = 0.3;
  Increment increment = Increment::from_last_step;
  std::vector<Boundary> boundaries;
  StiffLayers stiff_layers;
  LinearSolverKind linear_solver = LinearSolverKind::automatic;
  double tolerance = 1e-4;
  int max_iterations = 1000;
  Limits warn;
  Limits stop = {.min_volume_ratio = 0.01};
  std::optional<Limits> remesh; ///< a mesh beyond them is replaced after the step
  int max_sub_increments = 1;
  double step = 0; ///< stand-alone [time]
  int steps = 0;
  OutputSettings output;
};

struct Case {
  Settings settings;
  mesh::Mesh mesh;
};

/// Reads and validates a config and its mesh. Errors (ErrorKind::config): all of them at once, as
/// "FILE:LINE:COLUMN: error: TEXT". A participant needs an interface.
[[nodiscard]] Result<Case> load_case(const std::filesystem::path& file, Role role = Role::alone);

} // namespace drogue::mesh_mover
