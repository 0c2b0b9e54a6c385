// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/la_krylov/block_matrix.hpp"
#include "fluid_solver/flow_parameters.hpp"
#include "fluid_solver/fluid_mesh.hpp"
#include "fluid_solver/step_data.hpp"

namespace drogue::fluid {

/// The elements that touch a rank's own nodes, in batches of eight, with the places of their contributions.
/// Elements on the border between ranks are computed by each of them, so that no sum depends on the order of
/// messages. m: nodes of an element.
struct LocalElements {
  LocalElements(const FluidMesh& mesh, const la::RowRange& own, const la::LocalPattern& pattern);

  int dimension = 3;
  std::int32_t batches = 0;       ///< even: tangents take two at a time
  std::vector<std::int32_t> node; ///< {batches, 8, m} nodes; filled up with the last element
  std::vector<std::int32_t> row;  ///< {batches, 8, m} own row, or -1
  /// {batches, 8, m * m} twice the position in the pattern, plus one for the element whose block is
  /// the first to be added there; or -1
  std::vector<std::int32_t> entry;

 private:
  void mark_first(std::size_t positions);
};

/// Adds all element contributions to `residual` (own rows, {rows, unknowns}) and, unless null, makes
/// `jacobian` their sum, whatever it held before; scalar entry (i, j) of each block is multiplied by
/// scale[i] scale[j]. unknowns = 4: semi-discrete, 8: DSD/SST.
template <int unknowns>
void add_elements(const LocalElements& elements, const StepData& data, const FlowParameters& parameters,
                  std::span<const double, unknowns> scale, std::span<double> residual,
                  la::BlockMatrix<unknowns>* jacobian) noexcept;

extern template void add_elements<4>(const LocalElements&, const StepData&, const FlowParameters&,
                                     std::span<const double, 4>, std::span<double>,
                                     la::BlockMatrix<4>*) noexcept;
extern template void add_elements<8>(const LocalElements&, const StepData&, const FlowParameters&,
                                     std::span<const double, 8>, std::span<double>,
                                     la::BlockMatrix<8>*) noexcept;

} // namespace drogue::fluid
