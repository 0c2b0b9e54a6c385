// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.hpp"

namespace drogue::io {

/// What happens to results of an earlier part of the run.
enum class Existing { replace, keep };

/// A time series: a header line, then a row of numbers at a time, flushed at once so that nothing written is
/// lost: a full disk is noticed at the row that does not fit. Numbers are printed with seventeen significant
/// digits at most (shortest form that reads back the same).
class CsvWriter {
 public:
  CsvWriter() = default;
  /// With Existing::keep a file that exists is continued: what it holds stays, the header included.
  [[nodiscard]] static Result<CsvWriter> create(const std::filesystem::path& file,
                                                std::vector<std::string> columns,
                                                Existing existing = Existing::replace);
  /// Errors (ErrorKind::internal): the row cannot be written; the rows before it stay. @pre one value a
  /// column
  [[nodiscard]] Result<void> row(std::span<const double> values);
  [[nodiscard]] Result<void> row(std::initializer_list<double> values) {
    return row(std::span(values.begin(), values.size()));
  }
  [[nodiscard]] std::size_t column_count() const { return columns_; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  /// Length of the file [bytes].
  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// Drops what was written behind `size`. Errors: the file is shorter (ErrorKind::config), or cannot be cut.
  [[nodiscard]] Result<void> cut(std::uint64_t size);

 private:
  std::filesystem::path file_;
  std::ofstream stream_;
  std::size_t columns_ = 0;
  std::uint64_t size_ = 0;
};

} // namespace drogue::io
