// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/io/state_file.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <span>

#include "common/base/hash.hpp"
#include "common/io/atomic_file.hpp"
#include "drogue/v1/state.pb.h"

namespace drogue::io {
namespace {

static_assert(std::endian::native == std::endian::little, "state files hold little-endian values");

constexpr std::array<char, 5> magic = {'D', 'R', 'G', 'S', 1};
/// No solver needs a longer header; a longer one is a damaged length.
constexpr std::uint32_t max_header_length = 1U << 24U;

Error damaged(const std::filesystem::path& file, const std::string& why) {
  return config_error("{}: not a valid state file: {}", file.string(), why);
}

bool read_bytes(std::istream& in, void* to, std::uint64_t count) {
  in.read(static_cast<char*>(to), static_cast<std::streamsize>(count));
  return in.good();
}

/// Number of values of an array, when its header agrees with itself.
Result<std::uint64_t> value_count(const std::filesystem::path& file, const v1::ArrayHeader& header) {
  if (header.type() != v1::ArrayHeader::FLOAT64)
    return damaged(file, fmt::format("array \"{}\" is not of type FLOAT64", header.name()));
  std::uint64_t count = 1;
  for (const std::uint64_t extent : header.shape()) {
    if (extent != 0 && count > std::numeric_limits<std::uint64_t>::max() / 8 / extent)
      return damaged(file, fmt::format("array \"{}\" has an impossible shape", header.name()));
    count *= extent;
  }
  if (count * 8 != header.byte_length())
    return damaged(file, fmt::format("array \"{}\" has {} bytes but its shape needs {}", header.name(),
                                     header.byte_length(), count * 8));
  return count;
}

Result<v1::StateHeader> read_header(const std::filesystem::path& file, std::istream& in) {
  std::array<char, magic.size()> start{};
  std::uint32_t length = 0;
  if (!read_bytes(in, start.data(), start.size()) ||
      !std::equal(start.begin(), start.begin() + 4, magic.begin()))
    return damaged(file, "it does not start with \"DRGS\"");
  if (start[4] != magic[4])
    return damaged(file, fmt::format("version {}, this program reads version 1", static_cast<int>(start[4])));
  if (!read_bytes(in, &length, sizeof length)) return damaged(file, "truncated in the header");
  if (length > max_header_length) return damaged(file, fmt::format("a header of {} bytes", length));
  std::string bytes(length, '\0');
  if (!read_bytes(in, bytes.data(), length)) return damaged(file, "truncated in the header");
  v1::StateHeader header;
  if (!header.ParseFromString(bytes)) return damaged(file, "the header cannot be decoded");
  return header;
}

/// Checks that the arrays announced in the header fill the rest of the file exactly, before memory is taken.
Result<void> check_size(const std::filesystem::path& file, const v1::StateHeader& header,
                        std::uint64_t rest) {
  for (const v1::ArrayHeader& array : header.array()) {
    const auto count = value_count(file, array);
    if (!count) return count.error();
    if (array.byte_length() > rest)
      return damaged(file, fmt::format("truncated in array \"{}\"", array.name()));
    rest -= array.byte_length();
  }
  if (rest != 0) return damaged(file, fmt::format("{} bytes after the last array", rest));
  return {};
}

v1::StateHeader header_of(const State& state) {
  v1::StateHeader header;
  header.set_kind(state.kind);
  header.set_mesh_hash(state.mesh_hash);
  header.set_time(state.time);
  header.set_step(state.step);
  for (const StateArray& array : state.arrays) {
    v1::ArrayHeader& entry = *header.add_array();
    entry.set_name(array.name);
    entry.set_type(v1::ArrayHeader::FLOAT64);
    for (const std::uint64_t extent : array.shape) entry.add_shape(extent);
    entry.set_byte_length(array.values.size() * sizeof(double));
    entry.set_crc32(crc32(std::as_bytes(std::span(array.values))));
  }
  return header;
}

} // namespace

const StateArray* State::find(const std::string& name) const {
  const auto found =
      std::find_if(arrays.begin(), arrays.end(), [&](const StateArray& a) { return a.name == name; });
  return found == arrays.end() ? nullptr : &*found;
}

Result<void> write_state(const std::filesystem::path& file, const State& state) {
  const v1::StateHeader header = header_of(state);
  for (const v1::ArrayHeader& array : header.array())
    if (const auto count = value_count(file, array); !count)
      return internal_error("cannot write {}: array \"{}\" does not fill its shape", file.string(),
                            array.name());
  const std::string bytes = header.SerializeAsString();
  const auto length = static_cast<std::uint32_t>(bytes.size());
  auto out = AtomicFile::create(file);
  if (!out) return out.error();
  DROGUE_TRY(out->write_values(std::span<const char>(magic)));
  DROGUE_TRY(out->write_values(std::span<const std::uint32_t>(&length, 1)));
  DROGUE_TRY(out->write(bytes));
  for (const StateArray& array : state.arrays)
    DROGUE_TRY(out->write_values(std::span<const double>(array.values)));
  return out->commit();
}

Result<State> read_state(const std::filesystem::path& file) {
  std::error_code no_size;
  const std::uint64_t size = std::filesystem::file_size(file, no_size);
  std::ifstream in(file, std::ios::binary);
  if (no_size || !in)
    return config_error("{}: cannot be read: {}", file.string(),
                        no_size ? no_size.message() : std::strerror(errno));
  const auto header = read_header(file, in);
  if (!header) return header.error();
  DROGUE_TRY(check_size(file, *header, size - static_cast<std::uint64_t>(in.tellg())));

  State state{header->kind(), header->mesh_hash(), header->time(), header->step(), {}};
  for (const v1::ArrayHeader& array : header->array()) {
    if (state.find(array.name()) != nullptr)
      return damaged(file, fmt::format("array \"{}\" appears twice", array.name()));
    std::vector<double> values(array.byte_length() / sizeof(double));
    if (!read_bytes(in, values.data(), array.byte_length()))
      return damaged(file, fmt::format("truncated in array \"{}\"", array.name()));
    if (crc32(std::as_bytes(std::span(values))) != array.crc32())
      return damaged(file, fmt::format("wrong checksum of array \"{}\"", array.name()));
    state.add(array.name(), {array.shape().begin(), array.shape().end()}, std::move(values));
  }
  return state;
}

} // namespace drogue::io
