// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/isa.hpp"
#include "common/la_krylov/block_kernels.hpp"
#include "fluid_solver/element_kernels.hpp"
#include "tests/fluid_solver/box.hpp"

/// Every instruction set that this processor has gives what the baseline gives, to rounding.
namespace drogue::fluid {
namespace {

/// A mesh, a step on it, and the places of its blocks.
struct Problem {
  explicit Problem(mesh::Mesh file)
      : mesh(FluidMesh::create(std::move(file)).value()),
        own{0, mesh.node_count()},
        pattern(la::local_pattern(mesh.graph, own)),
        elements(mesh, own, pattern) {
    const auto n = static_cast<std::size_t>(mesh.node_count());
    data.dt = 0.1;
    data.rate = 10;
    data.x_n = mesh.points;
    data.x_np1 = test::shaken(mesh.points, 0.02, 1, mesh.dimension);
    for (auto* v : {&data.u_n, &data.history, &data.f_n, &data.f_np1}) v->assign(3 * n, 0.0);
    data.unknowns.resize(8 * n);
    for (std::size_t i = 0; i < data.unknowns.size(); ++i)
      data.unknowns[i] = std::sin(static_cast<double>(i));
  }
  FluidMesh mesh;
  la::RowRange own;
  la::LocalPattern pattern;
  LocalElements elements;
  StepData data;
};

const FlowParameters parameters{.dt = 0.1, .nu = 0.02, .smagorinsky = 0.2, .lsic = true, .tau_dt = 0.1};

struct Values {
  std::vector<double> residual;
  std::vector<double> product; ///< Jacobian times the unknowns
  std::vector<double> solved;  ///< incomplete factor's solution of the product
};

template <int n>
Values values(const Problem& p, ElementKernels::Add<n> add, const la::BlockKernels<n>& block) {
  const auto rows = static_cast<std::size_t>(p.mesh.node_count()) * n;
  Values v{std::vector<double>(rows), std::vector<double>(rows), std::vector<double>(rows)};
  const std::vector<double> scale(static_cast<std::size_t>(n) * n, 1.0);
  la::BlockMatrix<n> A(p.pattern);
  std::fill_n(A.block(0), p.pattern.column.size() * n * n, NAN); // what it held before does not matter
  add(p.elements, p.data, parameters, scale.data(), v.residual.data(), &A);
  const la::BlockRows r{p.pattern.rows, p.pattern.row_start.data(), p.pattern.column.data(),
                        p.pattern.diagonal.data()};
  block.multiply(r, A.block(0), p.data.unknowns.data(), v.product.data());
  for (std::int32_t i = 0; i < p.pattern.rows; ++i) // a plane flow has no third equation
    for (int q = 2; q < n; q += 4)
      if (p.mesh.dimension == 2) A.set_identity_row(i, q);
  std::vector<std::int32_t> position(static_cast<std::size_t>(p.pattern.columns()), -1);
  EXPECT_EQ(block.factor(r, A.block(0), position.data()), -1);
  const float* inverse = A.block(p.pattern.diagonal[0]);
  v.solved.assign(inverse, inverse + n * n);
  return v;
}

void expect_equal(const std::vector<double>& a, const std::vector<double>& b, const char* what) {
  ASSERT_EQ(a.size(), b.size());
  double scale = 0;
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    scale = std::max(scale, std::abs(b[i]));
    worst = std::max(worst, std::abs(a[i] - b[i]));
  }
  EXPECT_GT(scale, 0) << what;
  EXPECT_LT(worst, 2e-5 * scale) << what; // single precision, sums in another order
}

void expect_equal(const Values& a, const Values& b) {
  expect_equal(a.residual, b.residual, "residual");
  expect_equal(a.product, b.product, "product");
  expect_equal(a.solved, b.solved, "pivot");
}

struct OfIsa {
  const ElementKernels *plane, *space;
  const la::BlockKernels<4>* block_4;
  const la::BlockKernels<8>* block_8;
};
const OfIsa all[] = {{&baseline::element_kernels_2d, &baseline::element_kernels_3d,
                      &la::baseline::block_kernels_4, &la::baseline::block_kernels_8},
                     {&avx2::element_kernels_2d, &avx2::element_kernels_3d, &la::avx2::block_kernels_4,
                      &la::avx2::block_kernels_8},
                     {&avx512::element_kernels_2d, &avx512::element_kernels_3d, &la::avx512::block_kernels_4,
                      &la::avx512::block_kernels_8}};

TEST(InstructionSets, GiveTheSame) {
  const Problem plane(test::rectangle_mesh({5, 4}, {1, 1}));
  const Problem space(test::box_mesh({3, 3, 3}, {1, 1, 1}));
  for (int isa = 1; isa <= static_cast<int>(best_isa()); ++isa) {
    SCOPED_TRACE(name(static_cast<Isa>(isa)));
    const OfIsa& a = all[isa];
    const OfIsa& b = all[0];
    for (const auto& [problem, of_a, of_b] :
         {std::tuple{&plane, a.plane, b.plane}, std::tuple{&space, a.space, b.space}}) {
      expect_equal(values<4>(*problem, of_a->semi_discrete, *a.block_4),
                   values<4>(*problem, of_b->semi_discrete, *b.block_4));
      expect_equal(values<8>(*problem, of_a->space_time_2, *a.block_8),
                   values<8>(*problem, of_b->space_time_2, *b.block_8));
      expect_equal(values<8>(*problem, of_a->space_time_3, *a.block_8),
                   values<8>(*problem, of_b->space_time_3, *b.block_8));
    }
  }
}

} // namespace
} // namespace drogue::fluid
