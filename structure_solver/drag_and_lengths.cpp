// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/drag_and_lengths.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace drogue::structure {
namespace {

class Builder {
 public:
  Builder(const Settings& settings, config::Report& report, Model& model)
      : settings_(settings), report_(report), model_(model) {}

  void add_point_drag() {
    for (std::size_t i = 0; i < settings_.point_drag.size(); ++i) {
      const DragSettings& s = settings_.point_drag[i];
      const std::string field = fmt::format("point_drag[{}]", i);
      if (!known(field, s.group)) continue;
      model_.drag.push_back({fmt::format("drag on group \"{}\"", s.group), field + ".air_velocity",
                             model_.mesh.nodes_of(s.group), 1, s.k, false, s.air_velocity});
    }
  }

  void add_line_drag() {
    for (std::size_t i = 0; i < settings_.line_drag.size(); ++i) {
      const DragSettings& s = settings_.line_drag[i];
      const std::string field = fmt::format("line_drag[{}]", i);
      if (!known(field, s.group)) continue;
      DragLoad drag{fmt::format("drag on group \"{}\"", s.group),
                    field + ".air_velocity",
                    {},
                    2,
                    s.k,
                    s.cross_flow,
                    s.air_velocity};
      for (const AnyBatch& batch : model_.batches)
        if (const auto* lines = std::get_if<Batch<Line>>(&batch); lines && lines->group == s.group)
          drag.nodes.insert(drag.nodes.end(), lines->nodes.begin(), lines->nodes.end());
      if (drag.nodes.empty()) not_a_line(field, s.group);
      model_.drag.push_back(std::move(drag));
    }
  }

  void add_lengths() {
    for (std::size_t i = 0; i < settings_.natural_lengths.size(); ++i) {
      const NaturalLengthSettings& s = settings_.natural_lengths[i];
      const std::string field = fmt::format("natural_length[{}]", i);
      if (!known(field, s.group)) continue;
      if (controlled(s.group)) {
        error(field + ".group", fmt::format("group \"{}\" has a natural_length already", s.group));
        continue;
      }
      bool found = false;
      for (std::size_t b = 0; b < model_.batches.size(); ++b)
        if (const auto* lines = std::get_if<Batch<Line>>(&model_.batches[b]);
            lines && lines->group == s.group) {
          model_.lengths.push_back(
              {fmt::format("natural length of group \"{}\"", s.group), field, b, s.schedule});
          found = true;
        }
      if (!found) not_a_line(field, s.group);
    }
  }

 private:
  void error(const std::string& field, const std::string& text) {
    report_.error(settings_.source.where(field), text);
  }
  void not_a_line(const std::string& field, const std::string& group) {
    error(field + ".group", fmt::format("group \"{}\" is not a cable or truss of this config", group));
  }
  bool known(const std::string& field, const std::string& group) {
    if (model_.mesh.has_group(group)) return true;
    config::report_unknown_name(report_, settings_.source.where(field + ".group"), "group", group,
                                settings_.mesh.string(), model_.mesh.group_names());
    return false;
  }
  [[nodiscard]] bool controlled(const std::string& group) const {
    return std::any_of(model_.lengths.begin(), model_.lengths.end(), [&](const LengthControl& control) {
      return std::get<Batch<Line>>(model_.batches[control.batch]).group == group;
    });
  }

  const Settings& settings_;
  config::Report& report_;
  Model& model_;
};

} // namespace

void add_drag_and_lengths(const Settings& settings, config::Report& report, Model& model) {
  Builder builder(settings, report, model);
  builder.add_point_drag();
  builder.add_line_drag();
  builder.add_lengths();
}

} // namespace drogue::structure
