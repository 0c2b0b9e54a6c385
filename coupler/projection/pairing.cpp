// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/pairing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "coupler/projection/line_refinement.hpp"
#include "coupler/projection/load_transfer.hpp"
#include "coupler/projection/surface_integrals.hpp"

namespace drogue::projection {

using Eigen::Vector3d;
using mesh::ElementKind;

namespace {

constexpr int max_subdivisions = 16;
constexpr int max_refinements = 2;
/// Nodes of the structure that a triangle meets, where both meshes are about as fine.
constexpr std::size_t usual_rows = 8;
/// Enough to tell the mean of a square to some per cent.
constexpr std::size_t most_samples = 20000;
/// Two fluid layers lie on one another when they are this close, relative to the size.
constexpr double same_place = 1e-8;

bool all_linear_triangles(const Surface& s) {
  return std::all_of(s.blocks.begin(), s.blocks.end(),
                     [](const auto& block) { return block.kind == ElementKind::tri3; });
}

Vector3d position(ElementKind kind, const NodeMatrix& X, const std::array<double, 2>& parent) {
  const ElementShape shape = element_shape(kind, parent[0], parent[1]);
  return combine(shape.N, shape.nodes, X);
}

} // namespace

Pairing::Pairing(const Surface& structure, const Surface& fluid, const Settings& settings)
    : structure_(structure),
      fluid_(fluid),
      settings_(settings),
      made_([&] {
        InterfaceQuadrature q;
        q.structure_elements_ = std::make_shared<Elements>(structure);
        q.fluid_elements_ = std::make_shared<Elements>(fluid);
        return q;
      }()),
      on_structure_(*made_.structure_elements_),
      on_fluid_(*made_.fluid_elements_),
      tree_(on_structure_, structure.material),
      size_(extent(structure.material)),
      points_on_(static_cast<std::size_t>(on_structure_.count()), 0),
      area_on_(points_on_.size(), 0.0),
      slot_(structure.node_count(), -1) {
  made_.first_mass_.reserve(points_on_.size());
  std::int64_t values = 0;
  for (std::int32_t e = 0; e < on_structure_.count(); ++e) {
    const auto n = static_cast<std::int64_t>(on_structure_.nodes(e).size());
    made_.first_mass_.push_back(values);
    values += n * n;
  }
  made_.wet_mass_.assign(static_cast<std::size_t>(values), 0.0);
}

InterfaceQuadrature Pairing::make() {
  count_layers();
  tile();
  std::int32_t hint = -1;
  for (Sampled& s : sampled_) choose_rule(s, hint);
  for (int round = 0; round <= max_refinements; ++round) {
    for (Sampled& s : sampled_)
      if (s.stale) locate(s, hint);
    if (round == max_refinements || !refine_starved()) break;
  }
  for (const Sampled& s : sampled_) sum_points(s);
  finish();
  sample_for_defects();
  return std::move(made_);
}

void Pairing::count_layers() {
  const SurfaceTree fluid_tree(on_fluid_, fluid_.material);
  made_.elements_.reserve(static_cast<std::size_t>(on_fluid_.count()));
  for (std::int32_t e = 0; e < on_fluid_.count(); ++e) {
    const ElementKind kind = on_fluid_.kind(e);
    // A point away from the diagonals and medians, where another layer may have its edges.
    const bool triangle = kind == ElementKind::tri3 || kind == ElementKind::tri6;
    const Vector3d inside = position(kind, gather(on_fluid_.nodes(e), fluid_.material),
                                     triangle ? std::array{0.371, 0.293} : std::array{0.137, 0.061});
    const int layers = std::max(fluid_tree.layers(inside, same_place * size_), 1);
    made_.report_.fluid_sides = std::max(made_.report_.fluid_sides, layers);
    InterfaceQuadrature::Element element;
    element.kind = kind;
    element.nodes = on_fluid_.nodes(e);
    element.share = 1.0 / layers;
    made_.elements_.push_back(element);
  }
}

void Pairing::tile() {
  const auto sample = [this](std::int32_t e) { sampled_.push_back({e, 1, -1, 0, true}); };
  if (!all_linear_triangles(structure_)) {
    for (std::int32_t e = 0; e < on_fluid_.count(); ++e) sample(e);
    return;
  }
  TriangleTiling tiling(on_structure_, structure_.material, structure_.node_count());
  // Room that is not needed stays untouched; arrays that grow would stand in memory twice.
  const std::size_t rows = usual_rows * static_cast<std::size_t>(on_fluid_.count());
  made_.block_nodes_.reserve(rows);
  made_.block_values_.reserve(3 * rows);
  std::int32_t seed = -1;
  for (std::int32_t e = 0; e < on_fluid_.count(); ++e)
    if (on_fluid_.kind(e) != ElementKind::tri3 || !tile_element(tiling, e, seed)) sample(e);
}

bool Pairing::tile_element(TriangleTiling& tiling, std::int32_t e, std::int32_t& seed) {
  const InterfaceQuadrature::Element& element = made_.elements_[static_cast<std::size_t>(e)];
  const NodeMatrix material = gather(element.nodes, fluid_.material);
  const TriangleFrame frame({material.col(0), material.col(1), material.col(2)});
  seed = tree_.closest(position(ElementKind::tri3, material, parent_centre(ElementKind::tri3)), seed).element;
  if (!tiling.cover(frame, seed, settings_.largest_gap * size_)) return false;
  const double da =
      area_vector(element_shape(ElementKind::tri3, 0, 0), gather(element.nodes, fluid_.reference)).norm();
  start_block(e);
  for (const auto& [on, overlap] : tiling.tiles()) {
    const auto nodes = on_structure_.nodes(on);
    double* mass = made_.wet_mass_.data() + made_.first_mass_[static_cast<std::size_t>(on)];
    for (std::size_t a = 0; a < 3; ++a) {
      double* C = row(nodes[a], 3);
      for (std::size_t b = 0; b < 3; ++b) {
        C[b] += overlap.cross(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
        mass[3 * a + b] +=
            element.share * da * overlap.own(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
      }
    }
    points_on_[static_cast<std::size_t>(on)] += 3;
    area_on_[static_cast<std::size_t>(on)] += element.share * da * overlap.area;
    made_.report_.points += 3;
    const Vector3d at = position(ElementKind::tri3, material, overlap.gap_at);
    const Triangle X = tiling.corners(on);
    see_gap(overlap.gap, at);
    see_normals(frame.normal(), (X[1] - X[0]).cross(X[2] - X[0]), at);
  }
  // The parts miss the whole by rounding, up to the tiling's tolerance: constants and sums of forces are to
  // miss less.
  for (std::size_t b = 0; b < 3; ++b) {
    double* C = made_.block_values_.data() + element.first_value;
    const std::size_t values = made_.block_values_.size() - static_cast<std::size_t>(element.first_value);
    double sum = 0;
    for (std::size_t i = b; i < values; i += 3) sum += C[i];
    for (std::size_t i = b; i < values; i += 3) C[i] *= 1.0 / (6 * sum);
  }
  end_block(e);
  area_ += 0.5 * da;
  return true;
}

void Pairing::choose_rule(Sampled& s, std::int32_t& hint) {
  const ElementKind kind = on_fluid_.kind(s.element);
  const NodeMatrix X = gather(on_fluid_.nodes(s.element), fluid_.material);
  if (mesh::dimension(kind) == 1) {
    const auto breaks = refine_line(kind, X, tree_);
    s.rule = add_rule(kind, static_cast<int>(breaks.size()) - 1,
                      line_quadrature(breaks, settings_.quadrature_order));
    return;
  }
  // The centre: both sides of a canopy are to get the same rule.
  hint = tree_.closest(position(kind, X, parent_centre(kind)), hint).element;
  const double spacing =
      node_spacing(on_structure_.kind(hint), gather(on_structure_.nodes(hint), structure_.material));
  const int wanted =
      static_cast<int>(std::min(std::round(longest_edge(kind, X) / spacing), 1.0 * max_subdivisions));
  s.rule = find_rule(kind, std::max(wanted, 1));
}

void Pairing::locate(Sampled& s, std::int32_t& hint) {
  const ElementKind kind = on_fluid_.kind(s.element);
  if (s.refine > 1) {
    const int n = made_.rules_[static_cast<std::size_t>(s.rule)].subdivisions;
    s.rule = find_rule(kind, std::min(s.refine * n, max_subdivisions));
  }
  const NodeMatrix X = gather(on_fluid_.nodes(s.element), fluid_.material);
  s.first = static_cast<std::int64_t>(meetings_.size());
  for (const ElementShape& shape : made_.rules_[static_cast<std::size_t>(s.rule)].shapes) {
    const Located found = tree_.closest(combine(shape.N, shape.nodes, X), hint);
    hint = found.element;
    meetings_.push_back({hint, found.point.xi, found.point.eta, std::sqrt(found.point.distance2)});
  }
  s.refine = 1;
  s.stale = false;
}

bool Pairing::refine_starved() {
  const auto meetings_of = [this](const Sampled& s) {
    return std::span(meetings_).subspan(static_cast<std::size_t>(s.first),
                                        made_.rules_[static_cast<std::size_t>(s.rule)].weights.size());
  };
  std::vector<std::int32_t> points = points_on_;
  for (const Sampled& s : sampled_)
    for (const Meeting& m : meetings_of(s)) ++points[static_cast<std::size_t>(m.element)];
  bool any = false;
  std::vector<char> starved(structure_.node_count(), 0);
  for (std::int32_t e = 0; e < on_structure_.count(); ++e) {
    const auto nodes = on_structure_.nodes(e);
    const auto n = static_cast<std::size_t>(points[static_cast<std::size_t>(e)]);
    if (n == 0 || n >= nodes.size()) continue;
    any = true;
    for (const std::int32_t node : nodes) starved[static_cast<std::size_t>(node)] = 1;
  }
  if (!any) return false;
  bool refined = false;
  for (Sampled& s : sampled_) {
    const auto near = [&](const Meeting& m) {
      const auto nodes = on_structure_.nodes(m.element);
      return std::any_of(nodes.begin(), nodes.end(),
                         [&](std::int32_t i) { return starved[static_cast<std::size_t>(i)] != 0; });
    };
    const auto met = meetings_of(s);
    if (mesh::dimension(on_fluid_.kind(s.element)) == 1 || std::none_of(met.begin(), met.end(), near))
      continue;
    s.refine = 2;
    s.stale = refined = true;
  }
  return refined;
}

void Pairing::sum_points(const Sampled& s) {
  InterfaceQuadrature::Element& element = made_.elements_[static_cast<std::size_t>(s.element)];
  const InterfaceQuadrature::Rule& rule = made_.rules_[static_cast<std::size_t>(s.rule)];
  const NodeMatrix material = gather(element.nodes, fluid_.material),
                   reference = gather(element.nodes, fluid_.reference);
  const bool flat = is_flat(element.kind);
  if (!flat) {
    element.rule = s.rule;
    element.first_point = static_cast<std::int64_t>(made_.point_offsets_.size()) - 1;
  }
  start_block(s.element);
  for (std::size_t q = 0; q < rule.weights.size(); ++q) {
    const ElementShape& shape = rule.shapes[q];
    const Meeting& m = meetings_[static_cast<std::size_t>(s.first) + q];
    const auto on = static_cast<std::size_t>(m.element);
    const auto nodes = on_structure_.nodes(m.element);
    const ElementShape source = element_shape(on_structure_.kind(m.element), m.xi, m.eta);
    const double da = rule.weights[q] * area_vector(shape, reference).norm();
    double* mass = made_.wet_mass_.data() + made_.first_mass_[on];
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      double* C = row(nodes[a], element.nodes.size());
      for (std::size_t b = 0; b < element.nodes.size(); ++b)
        C[b] += (flat ? rule.weights[q] : da) * source.N[a] * shape.N[b];
      for (std::size_t b = 0; b < nodes.size(); ++b)
        mass[a * nodes.size() + b] += element.share * da * source.N[a] * source.N[b];
    }
    if (!flat) {
      made_.point_nodes_.insert(made_.point_nodes_.end(), nodes.begin(), nodes.end());
      made_.point_N_.insert(made_.point_N_.end(), source.N.begin(), source.N.begin() + source.nodes);
      made_.point_offsets_.push_back(static_cast<std::int64_t>(made_.point_nodes_.size()));
    }
    const Vector3d at = combine(shape.N, shape.nodes, material);
    ++points_on_[on];
    area_on_[on] += element.share * da;
    ++made_.report_.points;
    area_ += da;
    if (m.gap > settings_.largest_gap * size_) {
      ++made_.report_.unmatched_points;
      unmatched_ += da;
    }
    see_gap(m.gap, at);
    see_normals(area_vector(shape, material), area_vector(source, gather(nodes, structure_.material)), at);
  }
  end_block(s.element);
}

void Pairing::finish() {
  MatchReport& report = made_.report_;
  report.unmatched_area = unmatched_ / area_;
  report.largest_gap = largest_gap_ / size_;
  report.worst_normal_angle = std::acos(std::min(worst_cosine_, 1.0)) * 180 / std::numbers::pi;
  double dry = 0, total = 0;
  made_.wet_.assign(points_on_.size(), 0);
  for (std::int32_t e = 0; e < on_structure_.count(); ++e) {
    const auto i = static_cast<std::size_t>(e);
    const auto nodes = on_structure_.nodes(e);
    const double area = element_mass(on_structure_.kind(e), gather(nodes, structure_.reference)).area;
    const bool wet = area_on_[i] >= dry_share * area;
    total += area;
    if (!wet) dry += area;
    made_.wet_[i] = wet && static_cast<std::size_t>(points_on_[i]) >= nodes.size();
  }
  report.dry_area = dry / total;
}

void Pairing::sample_for_defects() {
  const auto elements = static_cast<std::size_t>(on_fluid_.count());
  const std::size_t points = element_quadrature(on_fluid_.kind(0), settings_.quadrature_order).size();
  const std::size_t stride = (elements * points + most_samples - 1) / most_samples;
  std::int32_t hint = -1;
  for (std::size_t i = 0; i < elements; i += stride) {
    const auto e = static_cast<std::int32_t>(i);
    const ElementKind kind = on_fluid_.kind(e);
    const NodeMatrix material = gather(on_fluid_.nodes(e), fluid_.material),
                     reference = gather(on_fluid_.nodes(e), fluid_.reference);
    for (const fem::SurfacePoint& q : element_quadrature(kind, settings_.quadrature_order)) {
      const ElementShape shape = element_shape(kind, q.xi, q.eta);
      const Located found = tree_.closest(combine(shape.N, shape.nodes, material), hint);
      hint = found.element;
      made_.samples_.push_back({e,
                                hint,
                                {q.xi, q.eta},
                                {found.point.xi, found.point.eta},
                                q.weight * area_vector(shape, reference).norm()});
    }
  }
}

std::int32_t Pairing::add_rule(ElementKind kind, int subdivisions,
                               std::span<const fem::SurfacePoint> points) {
  InterfaceQuadrature::Rule rule;
  rule.kind = kind;
  rule.subdivisions = subdivisions;
  for (const fem::SurfacePoint& q : points) {
    rule.weights.push_back(q.weight);
    rule.shapes.push_back(element_shape(kind, q.xi, q.eta));
  }
  made_.rules_.push_back(std::move(rule));
  return static_cast<std::int32_t>(made_.rules_.size()) - 1;
}

std::int32_t Pairing::find_rule(ElementKind kind, int subdivisions) {
  for (std::size_t i = 0; i < made_.rules_.size(); ++i)
    if (made_.rules_[i].kind == kind && made_.rules_[i].subdivisions == subdivisions)
      return static_cast<std::int32_t>(i);
  return add_rule(kind, subdivisions, composite_quadrature(kind, settings_.quadrature_order, subdivisions));
}

void Pairing::start_block(std::int32_t e) {
  InterfaceQuadrature::Element& element = made_.elements_[static_cast<std::size_t>(e)];
  element.first_node = static_cast<std::int64_t>(made_.block_nodes_.size());
  element.first_value = static_cast<std::int64_t>(made_.block_values_.size());
}

double* Pairing::row(std::int32_t node, std::size_t fluid_nodes) {
  std::int64_t& slot = slot_[static_cast<std::size_t>(node)];
  if (slot < 0) {
    slot = static_cast<std::int64_t>(made_.block_values_.size());
    made_.block_nodes_.push_back(node);
    made_.block_values_.resize(made_.block_values_.size() + fluid_nodes, 0.0);
  }
  return made_.block_values_.data() + slot;
}

void Pairing::end_block(std::int32_t e) {
  InterfaceQuadrature::Element& element = made_.elements_[static_cast<std::size_t>(e)];
  element.node_count =
      static_cast<std::int32_t>(static_cast<std::int64_t>(made_.block_nodes_.size()) - element.first_node);
  for (const std::int32_t node : made_.block_nodes(element)) slot_[static_cast<std::size_t>(node)] = -1;
}

void Pairing::see_gap(double gap, const Vector3d& at) {
  if (gap <= largest_gap_) return;
  largest_gap_ = gap;
  made_.report_.largest_gap_at = {at[0], at[1], at[2]};
}

void Pairing::see_normals(const Vector3d& a, const Vector3d& b, const Vector3d& at) {
  const double lengths = std::sqrt(a.squaredNorm() * b.squaredNorm());
  if (!(lengths > 0) || std::abs(a.dot(b)) >= worst_cosine_ * lengths) return;
  worst_cosine_ = std::abs(a.dot(b)) / lengths;
  made_.report_.worst_normal_at = {at[0], at[1], at[2]};
}

} // namespace drogue::projection
