// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

#include "common/base/result.hpp"

namespace drogue::io {

/// A file that appears complete or not at all: everything goes to a temporary file in the same folder,
/// `commit` flushes it to the disk and renames it into place. Without `commit` the destructor removes the
/// temporary file and whatever stood at the place before stays as it was.
///
/// All errors are ErrorKind::internal and name the file and the system's reason.
class AtomicFile {
 public:
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;
  ~AtomicFile();

  /// Opens the temporary file; missing parent folders are created.
  [[nodiscard]] static Result<AtomicFile> create(const std::filesystem::path& file);
  [[nodiscard]] Result<void> write(std::span<const std::byte> bytes);
  [[nodiscard]] Result<void> write(std::string_view text) { return write(std::as_bytes(std::span(text))); }
  template <class T>
  [[nodiscard]] Result<void> write_values(std::span<const T> values) {
    return write(std::as_bytes(values));
  }
  [[nodiscard]] Result<void> commit();

 private:
  AtomicFile(std::filesystem::path file, std::filesystem::path temporary, int descriptor);

  std::filesystem::path file_;
  std::filesystem::path temporary_;
  int descriptor_;
};

/// Writes a whole file by way of AtomicFile.
[[nodiscard]] Result<void> write_file(const std::filesystem::path& file, std::string_view content);

} // namespace drogue::io
