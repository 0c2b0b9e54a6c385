// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <google/protobuf/message.h>

#include "common/base/result.hpp"

namespace drogue::config {

/// Collects every error of a config, each with file:line:column, so that all of them are reported at once.
class Report {
 public:
  /// Adds "FILE:LINE:COLUMN: error: TEXT".
  void error(const std::string& where, const std::string& text);
  [[nodiscard]] bool ok() const { return lines_.empty(); }
  [[nodiscard]] const std::vector<std::string>& lines() const { return lines_; }
  /// All lines as one Error of kind config.
  [[nodiscard]] Error as_error() const;

 private:
  std::vector<std::string> lines_;
};

/// Where each field of a parsed config stands in its file.
class Source {
 public:
  Source() = default;
  explicit Source(std::filesystem::path file) : file_(std::move(file)) {}

  /// "FILE:LINE:COLUMN" of a field given by its path, e.g. "boundary[2].name"; of the nearest enclosing field
  /// that is in the file when the field itself is not; "FILE" when none is.
  [[nodiscard]] std::string where(std::string_view path) const;
  /// `name` resolved against the folder of the config.
  [[nodiscard]] std::filesystem::path resolve(const std::string& name) const;
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

  /// False when the text stops making sense somewhere: what stands behind is unknown, and not worth checking.
  [[nodiscard]] bool parsed() const { return parsed_; }
  void set_parsed() { parsed_ = true; }
  void set(std::string path, int line, int column) { positions_[std::move(path)] = {line, column}; }

 private:
  struct Position {
    int line = 0;
    int column = 0;
  };
  std::filesystem::path file_;
  std::map<std::string, Position, std::less<>> positions_;
  bool parsed_ = false;
};

/// Parses a text-format config into `message` and checks every rule of its schema
/// (proto/drogue/v1/rules.proto): unknown and misspelt fields, wrong types, values out of range, required
/// fields, missing input files, expressions that do not parse. All errors land in `report`. Returns the
/// positions of the fields.
[[nodiscard]] Source load(const std::filesystem::path& file, google::protobuf::Message& message,
                          Report& report);

/// Reports a name that is not among the valid ones: "no boundary named \"inflw\" in mesh.msh; did you mean
/// \"inflow\"? (there are: inflow, outflow)".
void report_unknown_name(Report& report, const std::string& where, std::string_view what,
                         std::string_view name, std::string_view in, std::span<const std::string> valid);

} // namespace drogue::config
