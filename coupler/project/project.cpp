// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/project/project.hpp"

#include <chrono>
#include <cmath>

#include "common/config/expression.hpp"
#include "common/io/vtu.hpp"
#include "coupler/project/surface_file.hpp"
#include "coupler/projection/interface.hpp"
#include "coupler/projection/surface_integrals.hpp"

namespace drogue::coupler {
namespace {

using Clock = std::chrono::steady_clock;
using Eigen::Vector3d;

constexpr int timed_transfers = 10;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

Result<config::VectorExpression> parse(const std::string& text) {
  config::VectorExpression expressions;
  std::size_t count = 0, first = 0;
  for (std::size_t last = 0; last != std::string::npos; first = last + 1, ++count) {
    last = text.find(';', first);
    if (count == 3) return config_error("\"{}\": more than three expressions", text);
    auto parsed =
        config::Expression::parse(text.substr(first, last == std::string::npos ? last : last - first));
    if (!parsed) return parsed.error();
    expressions[count] = std::move(*parsed);
  }
  if (count == 2) return config_error("\"{}\": two expressions; one or three are expected", text);
  return expressions;
}

std::vector<double> sample(const config::VectorExpression& f, const projection::Surface& surface) {
  std::vector<double> values;
  values.reserve(surface.points.size());
  for (std::size_t i = 0; i < surface.points.size(); i += 3)
    for (const config::Expression& component : f)
      values.push_back(component(surface.points[i], surface.points[i + 1], surface.points[i + 2], 0));
  return values;
}

Result<std::vector<double>> values_of(const SurfaceFile& from, const std::string& name) {
  const auto found = from.mesh.node_fields.find(name);
  if (found == from.mesh.node_fields.end())
    return config_error("the mesh of {} has no field \"{}\" on its nodes", from.surface.name, name);
  const mesh::NodeField& field = found->second;
  if (field.components != 1 && field.components != 3)
    return config_error("the field \"{}\" of {} has {} components; one or three are expected", name,
                        from.surface.name, field.components);
  const auto components = static_cast<std::size_t>(field.components);
  std::vector<double> values(3 * from.nodes.size(), 0.0);
  for (std::size_t i = 0; i < from.nodes.size(); ++i)
    for (std::size_t k = 0; k < components; ++k)
      values[3 * i + k] = field.values[components * static_cast<std::size_t>(from.nodes[i]) + k];
  return values;
}

/// The field on both surfaces; `exact` is empty when it is not an expression.
struct Fields {
  std::vector<double> from, exact;
};

Result<Fields> make_fields(const ProjectCommand& command, const SurfaceFile& from, const SurfaceFile& to) {
  Fields fields;
  if (command.field.empty()) {
    const auto expressions = parse(command.expression);
    if (!expressions) return expressions.error();
    fields = {sample(*expressions, from.surface), sample(*expressions, to.surface)};
  } else {
    auto values = values_of(from, command.field);
    if (!values) return values.error();
    fields.from = std::move(*values);
  }
  for (const std::vector<double>* values : {&fields.from, &fields.exact})
    for (std::size_t i = 0; i < values->size(); ++i)
      if (!std::isfinite((*values)[i]))
        return config_error("the field is not finite in node {} of {}", i / 3,
                            values == &fields.from ? from.surface.name : to.surface.name);
  return fields;
}

void print_error(const char* what, const std::vector<double>& ours, const std::vector<double>& exact) {
  if (exact.empty()) return;
  double difference = 0, size = 0, largest = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    difference += (ours[i] - exact[i]) * (ours[i] - exact[i]);
    size += exact[i] * exact[i];
    largest = std::max(largest, std::abs(ours[i] - exact[i]));
  }
  fmt::print("  {}: relative error {:.3e} over the nodes, largest {:.3e}\n", what,
             size > 0 ? std::sqrt(difference / size) : std::sqrt(difference), largest);
}

void print_match(const projection::MatchReport& r, double set_up, double transfer) {
  fmt::print("  set-up {:.3g} s, {:.3g} ms a transfer; {} points, {}\n", set_up, 1e3 * transfer, r.points,
             r.matching ? "the same elements on the same nodes" : "meshes that do not match");
  fmt::print(
      "  unmatched area {:.3g} %, dry area {:.3g} %, largest gap {:.3g} of the size at ({:.4g}, {:.4g}, "
      "{:.4g}), worst angle of the normals {:.3g} degrees\n",
      100 * r.unmatched_area, 100 * r.dry_area, r.largest_gap, r.largest_gap_at[0], r.largest_gap_at[1],
      r.largest_gap_at[2], r.worst_normal_angle);
}

Result<std::vector<double>> as_displacement(const projection::Surface& from, const projection::Surface& to,
                                            const ProjectCommand& command, const Fields& fields) {
  const auto start = Clock::now();
  auto pair = projection::make_interface(from, to, command.settings);
  if (!pair) return pair.error();
  const double set_up = seconds_since(start);
  std::vector<double> d(to.points.size());
  const auto first = Clock::now();
  for (int i = 0; i < timed_transfers; ++i) DROGUE_TRY(pair->field.apply(fields.from, d));
  fmt::print("as displacement, by least squares\n");
  print_match(pair->report, set_up, seconds_since(first) / timed_transfers);
  print_error("displacement", d, fields.exact);
  std::array<double, 3> mean_from{}, mean_to{};
  const projection::SurfaceIntegrals on_from(from), on_to(to);
  on_from.mean(fields.from, 3, mean_from);
  on_to.mean(d, 3, mean_to);
  fmt::print("  mean ({:.8g}, {:.8g}, {:.8g}) before, ({:.8g}, {:.8g}, {:.8g}) after\n", mean_from[0],
             mean_from[1], mean_from[2], mean_to[0], mean_to[1], mean_to[2]);
  return d;
}

struct LoadResult {
  std::vector<double> forces, traction;
};

void print_balance(const char* what, const Vector3d& given, const Vector3d& received, double scale) {
  fmt::print("  {} ({:.8g}, {:.8g}, {:.8g}) given, ({:.8g}, {:.8g}, {:.8g}) received: defect {:.3e} of {}\n",
             what, given[0], given[1], given[2], received[0], received[1], received[2],
             scale > 0 ? (given - received).norm() / scale : 0, "the sum of all nodal magnitudes");
}

Result<LoadResult> as_load(const projection::Surface& from, const projection::Surface& to,
                           const ProjectCommand& command, const Fields& fields) {
  const auto start = Clock::now();
  auto pair = projection::make_interface(to, from, command.settings);
  if (!pair) return pair.error();
  const double set_up = seconds_since(start);
  LoadResult result{std::vector<double>(to.points.size()), std::vector<double>(to.points.size())};
  projection::LoadSums given;
  const auto first = Clock::now();
  for (int i = 0; i < timed_transfers; ++i)
    given = pair->load.from_traction({from.points, {}}, fields.from, result.forces);
  const double transfer = seconds_since(first) / timed_transfers;
  DROGUE_TRY(pair->load.recover_traction(result.forces, result.traction));
  const projection::LoadSums received = projection::sum_nodal(to.points, result.forces);
  double force = 0, moment = 0;
  for (std::size_t i = 0; i < result.forces.size(); i += 3) {
    const Vector3d f(result.forces[i], result.forces[i + 1], result.forces[i + 2]);
    force += f.norm();
    moment += f.norm() * Vector3d(to.points[i], to.points[i + 1], to.points[i + 2]).norm();
  }
  fmt::print("as load, by conservative nodal forces\n");
  print_match(pair->report, set_up, transfer);
  print_balance("force", given.force, received.force, force);
  print_balance("moment", given.moment, received.moment, moment);
  print_error("recovered traction", result.traction, fields.exact);
  return result;
}

void print_surface(const char* which, const projection::Surface& surface) {
  fmt::print("{:4} {}: {} nodes, {} elements, area {:.6g}\n", which, surface.name, surface.node_count(),
             projection::Elements(surface).count(), projection::SurfaceIntegrals(surface).area());
}

} // namespace

Result<void> project(const ProjectCommand& command) {
  const auto from = read_surface(command.from, command.from_group);
  if (!from) return from.error();
  const auto to = read_surface(command.to, command.to_group);
  if (!to) return to.error();
  const auto fields = make_fields(command, *from, *to);
  if (!fields) return fields.error();
  print_surface("from", from->surface);
  print_surface("to", to->surface);
  const auto d = as_displacement(from->surface, to->surface, command, *fields);
  if (!d) return d.error();
  const auto load = as_load(from->surface, to->surface, command, *fields);
  if (!load) return load.error();

  io::VtuData data{to->surface.points, {}, {}, {}};
  for (const mesh::ElementBlock& block : to->surface.blocks) data.blocks.push_back(&block);
  data.point_data = {{"displacement", 3, *d}, {"force", 3, load->forces}, {"traction", 3, load->traction}};
  if (!fields->exact.empty()) data.point_data.push_back({"exact", 3, fields->exact});
  DROGUE_TRY(io::write_vtu(command.output, data));
  fmt::print("written to {}\n", command.output.string());
  return {};
}

} // namespace drogue::coupler
