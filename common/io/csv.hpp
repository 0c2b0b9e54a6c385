// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.hpp"

namespace drogue::io {

/// A time series: a header line, then a row of numbers at a time, flushed at once so that nothing written is
/// lost: a full disk is noticed at the row that does not fit. Numbers are printed with seventeen significant
/// digits at most (shortest form that reads back the same).
class CsvWriter {
 public:
  CsvWriter() = default;
  [[nodiscard]] static Result<CsvWriter> create(const std::filesystem::path& file,
                                                std::vector<std::string> columns);
  /// Errors (ErrorKind::internal): the row cannot be written; the rows before it stay. @pre one value a
  /// column
  [[nodiscard]] Result<void> row(std::span<const double> values);
  [[nodiscard]] Result<void> row(std::initializer_list<double> values) {
    return row(std::span(values.begin(), values.size()));
  }
  [[nodiscard]] std::size_t column_count() const { return columns_; }

 private:
  std::filesystem::path file_;
  std::ofstream stream_;
  std::size_t columns_ = 0;
};

} // namespace drogue::io
