// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/record/record_file.hpp"

#include <array>
#include <cstring>

namespace drogue::coupler::record {
namespace {

constexpr std::array<char, 5> magic{'D', 'R', 'G', 'R', 1};
constexpr std::uint32_t max_frames = 66; // of a message, docs/protocol.md

template <class T>
void put(std::ofstream& stream, T number) {
  std::array<char, sizeof(T)> bytes{};
  std::memcpy(bytes.data(), &number, sizeof number);
  stream.write(bytes.data(), bytes.size());
}

} // namespace

Result<Writer> Writer::create(const std::filesystem::path& file) {
  std::error_code failure;
  std::filesystem::create_directories(file.parent_path(), failure);
  std::ofstream stream(file, std::ios::binary);
  stream.write(magic.data(), magic.size());
  if (!stream) return internal_error("cannot write {}", file.string());
  return Writer(file, std::move(stream));
}

Result<void> Writer::add(Direction direction, const wire::Frames& frames) {
  put(stream_, static_cast<std::uint8_t>(direction));
  put(stream_, static_cast<std::uint32_t>(frames.size()));
  for (const zmq::message_t& frame : frames) {
    put(stream_, static_cast<std::uint64_t>(frame.size()));
    stream_.write(static_cast<const char*>(frame.data()), static_cast<std::streamsize>(frame.size()));
  }
  stream_.flush(); // the last message before a crash is the one that matters
  return stream_ ? Result<void>() : internal_error("cannot write {}", file_.string());
}

Result<Reader> Reader::open(const std::filesystem::path& file) {
  std::error_code failure;
  const auto size = std::filesystem::file_size(file, failure);
  if (failure) return config_error("cannot read {}: {}", file.string(), failure.message());
  Reader reader(file, std::ifstream(file, std::ios::binary), size);
  std::array<char, magic.size()> head{};
  if (!reader.read(head.data(), head.size()) || head != magic)
    return config_error("{} is no record of this version: coupler run --record writes them", file.string());
  return reader;
}

bool Reader::read(void* to, std::uint64_t size) {
  return static_cast<bool>(stream_.read(static_cast<char*>(to), static_cast<std::streamsize>(size)));
}

Result<std::optional<Entry>> Reader::next() {
  std::uint8_t direction = 0;
  std::uint32_t count = 0;
  if (!read(&direction, sizeof direction) || !read(&count, sizeof count)) return std::optional<Entry>();
  if (direction > 1 || count > max_frames) return config_error("{} is damaged", file_.string());
  wire::Frames frames;
  for (std::uint32_t i = 0; i < count; ++i) {
    std::uint64_t length = 0;
    if (!read(&length, sizeof length)) return std::optional<Entry>();
    if (length > size_) return std::optional<Entry>();
    frames.emplace_back(static_cast<std::size_t>(length));
    if (!read(frames.back().data(), length)) return std::optional<Entry>();
  }
  auto message = wire::decode(frames);
  if (!message) return config_error("{} is damaged: {}", file_.string(), message.error().message);
  return std::optional<Entry>({static_cast<Direction>(direction), std::move(*message)});
}

} // namespace drogue::coupler::record
