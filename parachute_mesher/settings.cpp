// SPDX-License-Identifier: GPL-3.0-or-later
#include "parachute_mesher/settings.hpp"

#include "common/config/config.hpp"
#include "drogue/v1/parachute_mesher.pb.h"

namespace drogue::parachute {
namespace {

using v1::ParachuteConfig;

template <class Message>
ClothRows rows_of(const Canopy& canopy, const Message& m) {
  return cloth_rows(canopy, {.main_rows = m.main_rows(),
                             .skirt_rows = m.skirt_rows(),
                             .across_vent = m.across_vent(),
                             .across_seam = m.across_seam(),
                             .across_skirt = m.across_skirt(),
                             .across_exponent = m.across_exponent()});
}

template <class Message>
void check_rows(const ParachuteConfig& config, const Message& m, const std::string& section,
                const config::Source& source, config::Report& report) {
  if ((config.canopy().skirt_ratio() > 0) != (m.skirt_rows() > 0))
    report.error(
        source.where(section + ".skirt_rows"),
        fmt::format("skirt_rows is {} but the canopy's skirt_ratio is {}: a skirt needs rows of elements, "
                    "and only a skirt has them",
                    m.skirt_rows(), config.canopy().skirt_ratio()));
}

void check_structure(const ParachuteConfig& config, const config::Source& source, config::Report& report) {
  const auto& m = config.structure();
  check_rows(config, m, "structure", source, report);
  if (m.element() != v1::Q9) return;
  const bool equal =
      m.across_vent() == m.across_seam() && (m.skirt_rows() == 0 || m.across_seam() == m.across_skirt());
  if (!equal)
    report.error(
        source.where("structure.across_seam"),
        fmt::format("Q9 meshes need the same number of elements across everywhere, not {} at the vent, {} "
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

void check_rigging(const ParachuteConfig& config, const config::Source& source, config::Report& report) {
  const double r = config.canopy().diameter() * (0.5 - config.canopy().skirt_ratio());
  if (config.rigging().line_length() <= r)
    report.error(source.where("rigging.line_length"),
                 fmt::format("line_length {} does not reach the axis: the flat skirt edge has radius {}",
                             config.rigging().line_length(), r));
}

StructureSettings structure_settings(const ParachuteConfig& config, const Canopy& canopy,
                                     const config::Source& source) {
  return {.file = source.resolve(config.structure().file()),
          .quadratic = config.structure().element() == v1::Q9,
          .rows = rows_of(canopy, config.structure())};
}

FluidSettings fluid_settings(const ParachuteConfig& config, const Canopy& canopy,
                             const config::Source& source) {
  const auto& m = config.fluid();
  const double Dc = canopy.diameter;
  return {.file = source.resolve(m.file()),
          .structure_mesh = source.resolve(m.structure_mesh()),
          .structure_state = source.resolve(m.structure_state()),
          .rows = rows_of(canopy, m),
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
  check_rigging(config, source, report);
  if (config.has_structure()) check_structure(config, source, report);
  if (config.has_fluid()) check_fluid(config, source, report);
  if (!report.ok()) return report.as_error();

  Settings settings;
  settings.canopy = {.diameter = config.canopy().diameter(),
                     .vent_ratio = config.canopy().vent_ratio(),
                     .skirt_ratio = config.canopy().skirt_ratio(),
                     .gores = config.canopy().gores()};
  settings.rigging = {.line_length = config.rigging().line_length(),
                      .line_elements = config.rigging().line_elements(),
                      .vent_elements = config.rigging().vent_elements(),
                      .confluence_distance = config.rigging().confluence_distance()};
  if (config.has_structure()) settings.structure = structure_settings(config, settings.canopy, source);
  if (config.has_fluid()) settings.fluid = fluid_settings(config, settings.canopy, source);
  return settings;
}

} // namespace drogue::parachute
