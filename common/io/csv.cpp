// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/io/csv.hpp"

#include <cassert>
#include <cerrno>
#include <cstring>
#include <iterator>

namespace drogue::io {

namespace {

Error write_error(const std::filesystem::path& file) {
  return internal_error("cannot write {}: {}", file.string(), std::strerror(errno));
}

} // namespace

Result<CsvWriter> CsvWriter::create(const std::filesystem::path& file, std::vector<std::string> columns) {
  std::error_code error;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), error);
  CsvWriter writer;
  writer.file_ = file;
  writer.stream_.open(file, std::ios::trunc);
  writer.columns_ = columns.size();
  writer.stream_ << fmt::format("{}\n", fmt::join(columns, ",")) << std::flush;
  if (!writer.stream_) return write_error(file);
  return writer;
}

Result<void> CsvWriter::row(std::span<const double> values) {
  assert(values.size() == columns_);
  fmt::memory_buffer line;
  fmt::format_to(std::back_inserter(line), "{}\n", fmt::join(values, ","));
  stream_.write(line.data(), static_cast<std::streamsize>(line.size()));
  stream_.flush();
  return stream_ ? Result<void>() : write_error(file_);
}

} // namespace drogue::io
