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

Result<CsvWriter> CsvWriter::create(const std::filesystem::path& file, std::vector<std::string> columns,
                                    Existing existing) {
  std::error_code error;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), error);
  CsvWriter writer;
  writer.file_ = file;
  writer.columns_ = columns.size();
  if (existing == Existing::keep) writer.size_ = std::filesystem::file_size(file, error);
  if (error || existing == Existing::replace) writer.size_ = 0;
  if (writer.size_ == 0) std::ofstream(file, std::ios::trunc); // an error shows below
  writer.stream_.open(file, std::ios::app);                    // rows follow a cut
  if (writer.size_ > 0) return writer.stream_ ? Result<CsvWriter>(std::move(writer)) : write_error(file);
  const std::string header = fmt::format("{}\n", fmt::join(columns, ","));
  writer.stream_ << header << std::flush;
  if (!writer.stream_) return write_error(file);
  writer.size_ = header.size();
  return writer;
}

Result<void> CsvWriter::row(std::span<const double> values) {
  assert(values.size() == columns_);
  fmt::memory_buffer line;
  fmt::format_to(std::back_inserter(line), "{}\n", fmt::join(values, ","));
  stream_.write(line.data(), static_cast<std::streamsize>(line.size()));
  stream_.flush();
  if (!stream_) return write_error(file_);
  size_ += line.size();
  return {};
}

Result<void> CsvWriter::cut(std::uint64_t size) {
  if (size > size_)
    return config_error("{} has {} bytes, less than the {} it had at the checkpoint: it was altered",
                        file_.string(), size_, size);
  std::error_code error;
  std::filesystem::resize_file(file_, size, error);
  if (error) return internal_error("cannot cut {}: {}", file_.string(), error.message());
  size_ = size;
  return {};
}

} // namespace drogue::io
