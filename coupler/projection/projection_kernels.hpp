// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

/// The loops of a coupling iteration, compiled for each instruction set. Vectors of a node lie side by side
/// in rows of four or eight values.
namespace drogue::projection {

/// Linear triangles of the fluid with their products C_ab = int N_a(pi) N_b dxi deta, b = 0, 1, 2.
struct FlatTriangles {
  /// A triangle's nodes of the structure, and its C, {rows, 3}.
  struct Rows {
    std::int64_t first_node = 0, first_value = 0;
    std::int32_t count = 0;
  };
  std::int32_t count = 0;
  const std::int32_t* nodes = nullptr; ///< {count, 3}: of the fluid
  const Rows* rows = nullptr;          ///< {count}
  const std::int32_t* row_nodes = nullptr;
  const double* values = nullptr;
};

/// All {fluid nodes, 3}; null: no velocity.
struct FlatFluid {
  const double* points = nullptr;
  const double* velocity = nullptr;
};

/// Force, moment about the origin, and power of the load on the triangles.
struct FlatSums {
  std::array<double, 3> force{}, moment{};
  double power = 0;
};

/// A matrix by compressed rows.
struct RowMatrix {
  std::int32_t rows = 0;
  const std::int32_t* first = nullptr; ///< {rows + 1}
  const std::int32_t* column = nullptr;
  const double* value = nullptr;
};

struct ProjectionKernels {
  /// f {structure nodes, 4} += int N_a(pi) t da with t = p n, pressure {fluid nodes}.
  FlatSums (*load_of_pressure)(const FlatTriangles& triangles, const FlatFluid& fluid, const double* pressure,
                               double* f) noexcept;
  /// The same of a traction {fluid nodes, 3}.
  FlatSums (*load_of_traction)(const FlatTriangles& triangles, const FlatFluid& fluid, const double* traction,
                               double* f) noexcept;
  /// y {rows, 4} = A x, x {columns, 4}; the same with eight values in a row.
  void (*multiply_4)(const RowMatrix& A, const double* x, double* y) noexcept;
  void (*multiply_8)(const RowMatrix& A, const double* x, double* y) noexcept;
};

namespace baseline {
extern const ProjectionKernels projection_kernels;
}
namespace avx2 {
extern const ProjectionKernels projection_kernels;
}
namespace avx512 {
extern const ProjectionKernels projection_kernels;
}

/// For the processor at hand.
[[nodiscard]] const ProjectionKernels& projection_kernels();

} // namespace drogue::projection
