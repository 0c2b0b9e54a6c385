// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/surface_integrals.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "coupler/projection/element_matrix.hpp"

namespace drogue::projection {
namespace {

constexpr int degree = 4;

} // namespace

ElementMass element_mass(mesh::ElementKind kind, const NodeMatrix& X) {
  ElementMass mass;
  if (is_flat(kind)) {
    const double scale = area_vector(element_shape(kind, 0, 0), X).norm();
    mass.M.setZero();
    mass.M.topLeftCorner<3, 3>() = scale * flat_mass(kind);
    mass.area = scale * flat_mass(kind).sum();
    return mass;
  }
  mass.M.setZero();
  for (const fem::SurfacePoint& q : element_quadrature(kind, degree)) {
    const auto shape = element_shape(kind, q.xi, q.eta);
    const double da = q.weight * area_vector(shape, X).norm();
    mass.area += da;
    for (int a = 0; a < shape.nodes; ++a)
      for (int b = 0; b < shape.nodes; ++b)
        mass.M(a, b) += da * shape.N[static_cast<std::size_t>(a)] * shape.N[static_cast<std::size_t>(b)];
  }
  return mass;
}

SurfaceIntegrals::SurfaceIntegrals(const Surface& surface)
    : integral_(surface.node_count(), 0.0), lumped_(surface.node_count(), 0.0) {
  const Elements elements(surface);
  std::vector<double> values;
  std::vector<std::size_t> first;
  for (std::int32_t e = 0; e < elements.count(); ++e) {
    const auto nodes = elements.nodes(e);
    const ElementMass mass = element_mass(elements.kind(e), gather(nodes, surface.reference));
    area_ += mass.area;
    const double trace =
        mass.M.topLeftCorner(static_cast<Eigen::Index>(nodes.size()), static_cast<Eigen::Index>(nodes.size()))
            .trace();
    first.push_back(values.size());
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      const auto i = static_cast<std::size_t>(nodes[a]);
      const auto row = static_cast<Eigen::Index>(a);
      lumped_[i] += mass.area * mass.M(row, row) / trace;
      for (std::size_t b = 0; b < nodes.size(); ++b) {
        values.push_back(mass.M(row, static_cast<Eigen::Index>(b)));
        integral_[i] += values.back();
      }
    }
  }
  const auto n = static_cast<std::int32_t>(surface.node_count());
  const auto nodes_of = [&](std::int32_t e) { return elements.nodes(e); };
  M_ = sum_elements(
      n, n, elements_around(n, elements.count(), nodes_of),
      [&](std::int32_t e) {
        const auto nodes = elements.nodes(e);
        return ElementPart{nodes,        nodes, values.data() + first[static_cast<std::size_t>(e)],
                           nodes.size(), 1,     1};
      },
      true);
  for (int i = 0; i < n; ++i) // for v^T M v, the triangle above the diagonal is counted with that below
    for (int k = M_.outerIndexPtr()[i]; k < M_.outerIndexPtr()[i + 1]; ++k)
      if (M_.innerIndexPtr()[k] != i) M_.valuePtr()[k] *= 2;
}

namespace {

/// v^T M v, M as SurfaceIntegrals has it; `components` a number, or a constant of the same value.
template <class Components>
double squared(const Eigen::SparseMatrix<double, Eigen::RowMajor, int>& M, std::span<const double> v,
               Components components) noexcept {
  const auto c = static_cast<std::size_t>(components);
  const int* first = M.outerIndexPtr();
  double sum = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(M.rows()); ++i) {
    for (int k = first[i]; k < first[i + 1]; ++k) {
      const double* vj = v.data() + static_cast<std::size_t>(M.innerIndexPtr()[k]) * c;
      double product = 0;
      for (std::size_t j = 0; j < c; ++j) product += v[i * c + j] * vj[j];
      sum += M.valuePtr()[k] * product;
    }
  }
  return sum;
}

} // namespace

double SurfaceIntegrals::norm(std::span<const double> v, int components) const noexcept {
  const double sum =
      components == 3 ? squared(M_, v, std::integral_constant<int, 3>()) : squared(M_, v, components);
  return std::sqrt(std::max(sum, 0.0) / area_);
}

void SurfaceIntegrals::mean(std::span<const double> v, int components,
                            std::span<double> result) const noexcept {
  const auto c = static_cast<std::size_t>(components);
  std::fill(result.begin(), result.end(), 0.0);
  for (std::size_t i = 0; i < integral_.size(); ++i)
    for (std::size_t j = 0; j < c; ++j) result[j] += integral_[i] * v[i * c + j] / area_;
}

Eigen::Vector3d vector_area(const Surface& surface, std::span<const double> x) {
  const Elements elements(surface);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::int32_t e = 0; e < elements.count(); ++e) {
    const NodeMatrix nodes = gather(elements.nodes(e), x);
    if (is_flat(elements.kind(e))) {
      sum += flat_mass(elements.kind(e)).sum() * area_vector(element_shape(elements.kind(e), 0, 0), nodes);
      continue;
    }
    for (const fem::SurfacePoint& q : element_quadrature(elements.kind(e), degree))
      sum += q.weight * area_vector(element_shape(elements.kind(e), q.xi, q.eta), nodes);
  }
  return sum;
}

} // namespace drogue::projection
