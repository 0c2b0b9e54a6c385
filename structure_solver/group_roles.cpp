// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/group_roles.hpp"

#include <map>
#include <string>

#include <fmt/format.h>

namespace drogue::structure {
namespace {

/// Remembers where each name was used first, and reports the second use.
class Uses {
 public:
  Uses(const char* what, const config::Source& source, config::Report& report)
      : what_(what), source_(source), report_(report) {}

  void add(const std::string& field, const std::string& name) {
    const auto [first, inserted] = fields_.emplace(name, field);
    if (inserted) return;
    report_.error(source_.where(field),
                  fmt::format("{} \"{}\" is named here and in {} ({}); it can be one of them only", what_,
                              name, first->second, source_.where(first->second)));
  }
  template <class Items>
  void add_all(const char* kind, const Items& items) {
    for (std::size_t i = 0; i < items.size(); ++i) add(fmt::format("{}[{}].group", kind, i), items[i].group);
  }

 private:
  const char* what_;
  const config::Source& source_;
  config::Report& report_;
  std::map<std::string, std::string> fields_;
};

} // namespace

void check_group_roles(const Settings& settings, config::Report& report) {
  Uses elements("group", settings.source, report);
  elements.add_all("membrane", settings.membranes);
  elements.add_all("solid", settings.solids);
  elements.add_all("cable", settings.cables);
  elements.add_all("truss", settings.trusses);
  for (std::size_t i = 0; i < settings.ignored_groups.size(); ++i)
    elements.add(fmt::format("ignore_group[{}]", i), settings.ignored_groups[i]);
  Uses probes("probe", settings.source, report);
  for (std::size_t i = 0; i < settings.probes.size(); ++i)
    probes.add(fmt::format("probe[{}].name", i), settings.probes[i].name);
}

} // namespace drogue::structure
