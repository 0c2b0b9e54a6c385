// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/io/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace drogue::io {
namespace {

Error cannot_write(const std::filesystem::path& file, int system_error) {
  return internal_error("cannot write {}: {}", file.string(), std::strerror(system_error));
}

/// Makes the rename itself durable. Some file systems cannot sync a folder; the file's content is safe by
/// then.
void sync_folder(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
}

} // namespace

AtomicFile::AtomicFile(std::filesystem::path file, std::filesystem::path temporary, int descriptor)
    : file_(std::move(file)), temporary_(std::move(temporary)), descriptor_(descriptor) {}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : file_(std::move(other.file_)),
      temporary_(std::move(other.temporary_)),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

AtomicFile::~AtomicFile() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  ::unlink(temporary_.c_str());
}

Result<AtomicFile> AtomicFile::create(const std::filesystem::path& file) {
  std::error_code error;
  std::filesystem::create_directories(folder_of(file), error);
  if (error) return cannot_write(file, error.value());
  const auto temporary =
      folder_of(file) / fmt::format(".{}.{}.tmp", file.filename().string(), static_cast<long>(::getpid()));
  const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) return cannot_write(file, errno);
  return AtomicFile(file, temporary, descriptor);
}

Result<void> AtomicFile::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return cannot_write(file_, errno);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return {};
}

Result<void> AtomicFile::commit() {
  if (::fsync(descriptor_) != 0) return cannot_write(file_, errno);
  if (::rename(temporary_.c_str(), file_.c_str()) != 0) return cannot_write(file_, errno);
  ::close(std::exchange(descriptor_, -1));
  sync_folder(folder_of(file_));
  return {};
}

Result<void> write_file(const std::filesystem::path& file, std::string_view content) {
  auto out = AtomicFile::create(file);
  if (!out) return out.error();
  DROGUE_TRY(out->write(content));
  return out->commit();
}

} // namespace drogue::io
