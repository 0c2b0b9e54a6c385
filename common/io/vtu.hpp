// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.hpp"
#include "common/mesh/mesh.hpp"

namespace drogue::io {

/// A named array on the points or on the cells: shape {count, components}.
struct Array {
  std::string name;
  int components = 1;
  std::span<const double> values;
};

/// What one .vtu file shows. Nothing is copied: spans must live until the file is written.
struct VtuData {
  /// Coordinates, shape {node count, 3}.
  std::span<const double> points;
  /// Blocks to write as cells; cell arrays run over the blocks in this order.
  std::vector<const mesh::ElementBlock*> blocks;
  std::vector<Array> point_data;
  std::vector<Array> cell_data;
};

/// Writes appended binary with zlib compression. Written to a temporary file and renamed.
/// Errors: ErrorKind::internal when the file cannot be written (says why).
[[nodiscard]] Result<void> write_vtu(const std::filesystem::path& file, const VtuData& data);

/// Writes a .pvtu that joins pieces written with write_vtu(), all with the arrays of `data`; their paths are
/// stored relative to its folder. Errors: as write_vtu().
[[nodiscard]] Result<void> write_pvtu(const std::filesystem::path& file, const VtuData& data,
                                      std::span<const std::filesystem::path> pieces);

/// A .pvd collection, rewritten (and renamed into place) after every added file, so that it is valid at any
/// time.
class PvdCollection {
 public:
  PvdCollection() = default;
  explicit PvdCollection(std::filesystem::path file) : file_(std::move(file)) {}
  /// `vtu`, a .vtu or .pvtu, is stored relative to the collection's folder; nothing changes when it is the
  /// last one already.
  [[nodiscard]] Result<void> add(double time, const std::filesystem::path& vtu);
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] std::size_t size() const { return entries_.size(); }
  /// Continues the collection that stands in file() with its first `count` entries. Errors
  /// (ErrorKind::config): it has fewer.
  [[nodiscard]] Result<void> continue_from(std::size_t count);

 private:
  [[nodiscard]] Result<void> write() const;
  std::filesystem::path file_;
  std::vector<std::string> entries_; ///< lines of the file
};

} // namespace drogue::io
