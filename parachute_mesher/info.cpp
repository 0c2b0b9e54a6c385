// SPDX-License-Identifier: GPL-3.0-or-later
#include "parachute_mesher/info.hpp"

#include <limits>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "common/fem/quadrature.hpp"
#include "common/fem/shape.hpp"
#include "common/meshing/checks.hpp"
#include "common/meshing/quality.hpp"

namespace drogue::parachute {
namespace {

using Eigen::Vector3d;

Vector3d at(const mesh::Mesh& m, std::int32_t node) {
  return Vector3d::Map(m.points.data() + 3 * static_cast<std::ptrdiff_t>(node));
}

double area(const mesh::Mesh& m, const mesh::ElementBlock& block) {
  constexpr int degree = 4;
  const std::vector<fem::SurfacePoint> points = fem::surface_quadrature(block.kind, degree);
  double sum = 0;
  for (std::int32_t e = 0; e < block.count(); ++e)
    for (const fem::SurfacePoint& p : points) {
      const fem::SurfaceShape shape = fem::surface_shape(block.kind, p.xi, p.eta);
      Vector3d g1 = Vector3d::Zero(), g2 = Vector3d::Zero();
      for (std::size_t a = 0; a < block.element(e).size(); ++a) {
        g1 += shape.dN_dxi[a] * at(m, block.element(e)[a]);
        g2 += shape.dN_deta[a] * at(m, block.element(e)[a]);
      }
      sum += p.weight * g1.cross(g2).norm();
    }
  return sum;
}

double length(const mesh::Mesh& m, const mesh::ElementBlock& block) {
  double sum = 0;
  for (std::int32_t e = 0; e < block.count(); ++e)
    sum += (at(m, block.element(e)[1]) - at(m, block.element(e)[0])).norm();
  return sum;
}

double volume(const mesh::Mesh& m, const mesh::ElementBlock& block) {
  double sum = 0;
  for (std::int32_t e = 0; e < block.count(); ++e) {
    const auto n = block.element(e);
    const Vector3d o = at(m, n[0]);
    sum += (at(m, n[1]) - o).dot((at(m, n[2]) - o).cross(at(m, n[3]) - o)) / 6;
  }
  return sum;
}

std::string describe_points(const mesh::Mesh& m) {
  Eigen::AlignedBox3d box;
  for (std::int32_t i = 0; i < m.node_count(); ++i) box.extend(at(m, i));
  std::string text =
      fmt::format("  {} nodes, x {:.6g} .. {:.6g}, y {:.6g} .. {:.6g}, z {:.6g} .. {:.6g}\n", m.node_count(),
                  box.min().x(), box.max().x(), box.min().y(), box.max().y(), box.min().z(), box.max().z());
  for (const auto& [name, field] : m.node_fields)
    text += fmt::format("  node field \"{}\", {} components\n", name, field.components);
  return text;
}

std::string describe_block(const mesh::Mesh& m, const mesh::ElementBlock& block) {
  constexpr const char* quantity[] = {"", ", length ", ", area ", ", volume "};
  const int dimension = mesh::dimension(block.kind);
  return fmt::format("  {:<18} {} x {}{}{}\n", block.group, block.count(), mesh::name(block.kind),
                     quantity[dimension], dimension == 0 ? "" : fmt::format("{:.6g}", measure(m, block)));
}

std::string describe_tets(const meshing::TetMesh& tets) {
  const meshing::QualitySummary q = meshing::summarise_quality(tets.points, tets.tets);
  const Result<void> checked = meshing::check_volume(tets);
  return fmt::format(
      "  tetrahedra: smallest dihedral angle {:.3f} degrees ({} below 5, {} below 10), smallest mean "
      "ratio {:.4f}, smallest volume {:.4g}\n"
      "  checks: {}\n",
      q.smallest_angle, q.below_5_degrees, q.below_10_degrees, q.smallest_mean_ratio, q.smallest_volume,
      checked ? "conforming, every boundary face named" : checked.error().message);
}

const std::vector<meshing::Triangle>* find(const meshing::TetMesh& m, const char* name) {
  for (const meshing::NamedSurface& surface : m.boundaries)
    if (surface.name == name) return &surface.triangles;
  return nullptr;
}

std::string describe_canopy(const meshing::TetMesh& m) {
  const auto* upper = find(m, "canopy_upper");
  const auto* lower = find(m, "canopy_lower");
  if (upper == nullptr || lower == nullptr) return {};
  const Result<void> checked = meshing::check_two_sided(*upper, *lower);
  return fmt::format("  canopy: {} free edges, {}\n", meshing::free_edge_loops(*upper).size(),
                     checked ? "both sides together closed" : checked.error().message);
}

} // namespace

double measure(const mesh::Mesh& m, const mesh::ElementBlock& block) {
  switch (mesh::dimension(block.kind)) {
  case 1:
    return length(m, block);
  case 2:
    return area(m, block);
  case 3:
    return volume(m, block);
  default:
    return 0;
  }
}

std::string describe(const mesh::Mesh& m) {
  std::string text = describe_points(m);
  for (const mesh::ElementBlock& block : m.blocks) text += describe_block(m, block);
  const meshing::TetMesh tets = meshing::from_mesh(m);
  if (!tets.tets.empty()) text += describe_tets(tets) + describe_canopy(tets);
  return text;
}

Result<void> check(const mesh::Mesh& m) {
  const meshing::TetMesh tets = meshing::from_mesh(m);
  if (tets.tets.empty()) return {};
  DROGUE_TRY(meshing::check_volume(tets));
  const auto* upper = find(tets, "canopy_upper");
  const auto* lower = find(tets, "canopy_lower");
  return upper == nullptr || lower == nullptr ? Result<void>() : meshing::check_two_sided(*upper, *lower);
}

} // namespace drogue::parachute
