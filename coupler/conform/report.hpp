// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"

namespace drogue::coupler::conform {

enum class Verdict { passed, failed, not_applicable, not_reached };

/// What was found on one promise of docs/protocol.md.
struct Finding {
  Verdict verdict = Verdict::not_reached;
  std::string detail; ///< of a failure: what was expected and what came; of the others: why
};

/// The promises of the protocol, each with its name in reports, and what was found on them. The first failure
/// of a promise stays; a promise that was kept in one place and broken in another is broken.
class Report {
 public:
  void pass(std::string_view promise);
  void fail(std::string_view promise, const std::string& detail);
  void skip(std::string_view promise, const std::string& why);

  /// All promises but these do not count; an empty list restricts nothing.
  void restrict_to(const std::vector<std::string>& only);
  /// The names of all promises, in the order of the report.
  [[nodiscard]] static std::vector<std::string> names();

  /// Every promise that applies was checked, and kept.
  [[nodiscard]] bool conforms() const;
  /// One line a promise, and the figures.
  [[nodiscard]] std::string text() const;
  /// {"command": ..., "role": ..., "conforms": ..., "promises": [{"name", "promise", "verdict", "detail"}]}
  [[nodiscard]] std::string json(const std::vector<std::string>& command, const std::string& role) const;

 private:
  [[nodiscard]] Finding& at(std::string_view promise);
  [[nodiscard]] Finding found(std::string_view promise) const;
  std::map<std::string_view, Finding> findings_;
};

} // namespace drogue::coupler::conform
