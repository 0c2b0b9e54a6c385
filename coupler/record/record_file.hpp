// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <vector>

#include "common/base/result.hpp"
#include "participant/cpp/wire.hpp"

/// All messages between the coupler and one participant, as they travelled. The file begins with "DRGR" and a
/// byte, the version; each message is
///   u8   0: to the participant, 1: from it
///   u32  number of frames
///   for each frame: u64 length, bytes
/// with little-endian numbers. A record that ends in the middle of a message is one of a run that was cut
/// off.
namespace drogue::coupler::record {

enum class Direction : std::uint8_t { to_participant = 0, from_participant = 1 };

class Writer {
 public:
  /// Errors (ErrorKind::internal): the file cannot be written.
  [[nodiscard]] static Result<Writer> create(const std::filesystem::path& file);
  [[nodiscard]] Result<void> add(Direction direction, const wire::Frames& frames);

 private:
  Writer(std::filesystem::path file, std::ofstream stream)
      : file_(std::move(file)), stream_(std::move(stream)) {}
  std::filesystem::path file_;
  std::ofstream stream_;
};

struct Entry {
  Direction direction = Direction::to_participant;
  wire::Message message;
};

class Reader {
 public:
  /// Errors (ErrorKind::config): no such file, or not a record.
  [[nodiscard]] static Result<Reader> open(const std::filesystem::path& file);
  /// Nothing at the end of the record. Errors (ErrorKind::config): what is there is no message.
  [[nodiscard]] Result<std::optional<Entry>> next();

 private:
  Reader(std::filesystem::path file, std::ifstream stream, std::uint64_t size)
      : file_(std::move(file)), stream_(std::move(stream)), size_(size) {}
  [[nodiscard]] bool read(void* to, std::uint64_t size);
  std::filesystem::path file_;
  std::ifstream stream_;
  std::uint64_t size_; ///< of the file: no frame is longer
};

} // namespace drogue::coupler::record
