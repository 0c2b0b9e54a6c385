// SPDX-License-Identifier: GPL-3.0-or-later
#include "parachute_mesher/settings.hpp"

#include <numbers>

#include "common/config/config.hpp"
#include "drogue/v1/parachute_mesher.pb.h"

namespace drogue::parachute {
namespace {

using v1::ParachuteConfig;

bool has_skirt(const ParachuteConfig& config) {
  const auto& canopy = config.canopy();
  return canopy.shape() == v1::Canopy::FLAT && canopy.skirt_ratio() > 0;
}

/// Rows of the skirt: none by default where there is no skirt.
template <class Message>
int skirt_rows(const ParachuteConfig& config, const Message& m) {
  return m.has_skirt_rows() || has_skirt(config) ? m.skirt_rows() : 0;
}

template <class Message>
ClothRows rows_of(const ParachuteConfig& config, const Canopy& canopy, const Message& m) {
  return cloth_rows(canopy, {.main_rows = m.main_rows(),
                             .skirt_rows = skirt_rows(config, m),
                             .across_vent = m.across_vent(),
                             .across_seam = m.across_seam(),
                             .across_skirt = m.across_skirt(),
                             .across_exponent = m.across_exponent()});
}

template <class Message>
void check_rows(const ParachuteConfig& config, const Message& m, const std::string& section,
                const config::Source& source, config::Report& report) {
  const int skirt = skirt_rows(config, m);
  if (has_skirt(config) != (skirt > 0))
    report.error(
        source.where(section + ".skirt_rows"),
        fmt::format("skirt_rows is {} but the canopy's skirt_ratio is {}: a skirt needs rows of elements, "
                    "and only a skirt has them",
                    skirt, has_skirt(config) ? config.canopy().skirt_ratio() : 0));
  if (m.main_rows() <= config.canopy().gap_size())
    report.error(source.where(section + ".main_rows"),
                 fmt::format("main_rows {} is too few: each of the {} rings of cloth needs a row",
                             m.main_rows(), config.canopy().gap_size() + 1));
  const int per_line = config.canopy().lines_per_arm() - 1;
  if (config.canopy().shape() == v1::Canopy::CROSS && m.across_seam() % per_line != 0)
    report.error(
        source.where(section + ".across_seam"),
        fmt::format("across_seam {} must be a multiple of {}, so that every line of an arm ends on a node",
                    m.across_seam(), per_line));
}

void check_gaps(const ParachuteConfig& config, const Canopy& canopy, const config::Source& source,
                config::Report& report) {
  double free_from = canopy.s_vent() / canopy.s_seam();
  for (int i = 0; i < config.canopy().gap_size(); ++i) {
    const auto& gap = config.canopy().gap(i);
    if (!(gap.from() > free_from && gap.to() > gap.from()))
      report.error(
          source.where(fmt::format("canopy.gap[{}].from", i)),
          fmt::format("gap from {} to {} must lie beyond {:.6g}, the vent edge or the gap before it, and end "
                      "after it begins",
                      gap.from(), gap.to(), free_from));
    free_from = gap.to();
  }
}

void check_canopy(const ParachuteConfig& config, const Canopy& canopy, const config::Source& source,
                  config::Report& report) {
  const auto& given = config.canopy();
  if (given.shape() != v1::Canopy::FLAT && given.has_skirt_ratio() && given.skirt_ratio() > 0)
    report.error(source.where("canopy.skirt_ratio"), "only a FLAT canopy has a skirt: leave skirt_ratio out");
  if (has_skirt(config) && given.vent_ratio() >= 1 - 2 * given.skirt_ratio())
    report.error(source.where("canopy.vent_ratio"),
                 fmt::format("vent_ratio {} and skirt_ratio {}: the skirt would reach into the vent",
                             given.vent_ratio(), given.skirt_ratio()));
  if (given.shape() == v1::Canopy::CROSS && given.gap_size() > 0)
    report.error(source.where("canopy.gap[0]"), "a cross has no gaps");
  else
    check_gaps(config, canopy, source, report);
}

void check_structure(const ParachuteConfig& config, const config::Source& source, config::Report& report) {
  const auto& m = config.structure();
  check_rows(config, m, "structure", source, report);
  if (m.element() == v1::T3 || m.element() == v1::T6 || config.canopy().shape() == v1::Canopy::CROSS) return;
  const bool equal =
      m.across_vent() == m.across_seam() && (!has_skirt(config) || m.across_seam() == m.across_skirt());
  if (!equal)
    report.error(source.where("structure.across_seam"),
                 fmt::format("meshes of quadrilaterals need the same number of elements across everywhere, "
                             "not {} at the vent, {} "
                             "at the seam and {} at the skirt edge",
                             m.across_vent(), m.across_seam(), m.across_skirt()));
}

void check_fluid(const ParachuteConfig& config, const config::Source& source, config::Report& report) {
  const auto& m = config.fluid();
  check_rows(config, m, "fluid", source, report);
  if (m.largest_size() < m.canopy_size())
    report.error(source.where("fluid.largest_size"),
                 fmt::format("largest_size {} is below canopy_size {}", m.largest_size(), m.canopy_size()));
  if (m.has_wake_size() && m.wake_size() < m.canopy_size())
    report.error(source.where("fluid.wake_size"),
                 fmt::format("wake_size {} is below canopy_size {}", m.wake_size(), m.canopy_size()));
}

void check_rigging(const ParachuteConfig& config, const Canopy& canopy, const config::Source& source,
                   config::Report& report) {
  const auto& rigging = config.rigging();
  const double r = canopy.radius(canopy.s_skirt());
  if (rigging.line_length() <= r)
    report.error(
        source.where("rigging.line_length"),
        fmt::format("line_length {} does not reach the axis: the constructed skirt edge has radius {}",
                    rigging.line_length(), r));
  if (rigging.has_risers() && rigging.confluence_distance() == 0)
    report.error(source.where("rigging.confluence_distance"),
                 "with risers there are four confluence points: confluence_distance must be above 0");
  if (rigging.inner_line_elements() > 0 && canopy.shape == Shape::cross)
    report.error(source.where("rigging.inner_line_elements"),
                 "a cross has no vent from which inner lines could run");
}

mesh::ElementKind element_kind(v1::MembraneElement element) {
  switch (element) {
  case v1::T3:
    return mesh::ElementKind::tri3;
  case v1::T6:
    return mesh::ElementKind::tri6;
  case v1::Q4:
    return mesh::ElementKind::quad4;
  case v1::Q9:
    break;
  }
  return mesh::ElementKind::quad9;
}

Shape shape_of(v1::Canopy::Shape shape) {
  switch (shape) {
  case v1::Canopy::CONICAL:
    return Shape::conical;
  case v1::Canopy::HEMISPHERICAL:
    return Shape::hemispherical;
  case v1::Canopy::CROSS:
    return Shape::cross;
  case v1::Canopy::FLAT:
    break;
  }
  return Shape::flat;
}

Canopy canopy_of(const ParachuteConfig& config) {
  const auto& given = config.canopy();
  Canopy canopy{.diameter = given.diameter(),
                .vent_ratio = given.vent_ratio(),
                .skirt_ratio = has_skirt(config) ? given.skirt_ratio() : 0,
                .gores = given.gores(),
                .shape = shape_of(given.shape()),
                .cone_angle = given.cone_angle() * std::numbers::pi / 180,
                .gaps = {},
                .arm_width_ratio = given.arm_width_ratio(),
                .lines_per_arm = given.lines_per_arm()};
  for (const auto& gap : given.gap()) canopy.gaps.push_back({gap.from(), gap.to()});
  return canopy;
}

Rigging rigging_of(const ParachuteConfig& config) {
  const auto& given = config.rigging();
  Rigging rigging{.line_length = given.line_length(),
                  .line_elements = given.line_elements(),
                  .vent_elements = given.vent_elements(),
                  .confluence_distance = given.confluence_distance(),
                  .inner_line_elements = given.inner_line_elements()};
  if (given.has_risers())
    rigging.risers = {.length = given.risers().length(),
                      .elements = given.risers().elements(),
                      .confluence_depth = given.risers().confluence_depth(),
                      .payload_width = given.risers().payload_width(),
                      .payload_height = given.risers().payload_height()};
  return rigging;
}

StructureSettings structure_settings(const ParachuteConfig& config, const Canopy& canopy,
                                     const config::Source& source) {
  return {.file = source.resolve(config.structure().file()),
          .element = element_kind(config.structure().element()),
          .rows = rows_of(config, canopy, config.structure())};
}

FluidSettings fluid_settings(const ParachuteConfig& config, const Canopy& canopy,
                             const config::Source& source) {
  const auto& m = config.fluid();
  const double Dc = canopy.diameter;
  return {.file = source.resolve(m.file()),
          .structure_mesh = source.resolve(m.structure_mesh()),
          .structure_state = source.resolve(m.structure_state()),
          .rows = rows_of(config, canopy, m),
          .half_width = m.half_width() * Dc,
          .upstream = m.upstream() * Dc,
          .downstream = m.downstream() * Dc,
          .canopy_size = m.canopy_size(),
          .largest_size = m.largest_size(),
          .growth = m.growth(),
          .wake_size = m.has_wake_size() ? m.wake_size() : m.largest_size(),
          .wake_length = m.wake_length() * Dc};
}

} // namespace

Result<Settings> load_settings(const std::filesystem::path& file) {
  ParachuteConfig config;
  config::Report report;
  const config::Source source = config::load(file, config, report);
  if (!report.ok()) return report.as_error();
  const Canopy canopy = canopy_of(config);
  check_canopy(config, canopy, source, report);
  check_rigging(config, canopy, source, report);
  if (config.has_structure()) check_structure(config, source, report);
  if (config.has_fluid()) check_fluid(config, source, report);
  if (!report.ok()) return report.as_error();

  Settings settings{.canopy = canopy, .rigging = rigging_of(config), .structure = {}, .fluid = {}};
  if (config.has_structure()) settings.structure = structure_settings(config, settings.canopy, source);
  if (config.has_fluid()) settings.fluid = fluid_settings(config, settings.canopy, source);
  return settings;
}

} // namespace drogue::parachute
