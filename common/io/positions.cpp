// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/io/positions.hpp"

#include "common/io/state_file.hpp"

namespace drogue::io {
namespace {

constexpr const char* kind = "positions";

} // namespace

Result<void> save_positions(const std::filesystem::path& file, const ResultFiles& files) {
  State state;
  state.kind = kind;
  for (const CsvWriter* s : files.series)
    state.add(s->file().filename().string(), {1}, {static_cast<double>(s->size())});
  for (const PvdCollection* c : files.collections)
    state.add(c->file().filename().string(), {1}, {static_cast<double>(c->size())});
  return write_state(file, state);
}

Result<void> restore_positions(const std::filesystem::path& file, const ResultFiles& files) {
  const auto state = read_state(file);
  if (!state) return state.error();
  const auto position = [&](const std::filesystem::path& of) -> Result<std::uint64_t> {
    const StateArray* array = state->find(of.filename().string());
    if (!array || array->values.size() != 1)
      return config_error("{} does not say how far {} was written", file.string(), of.string());
    return static_cast<std::uint64_t>(array->values[0]);
  };
  for (CsvWriter* s : files.series) {
    const auto size = position(s->file());
    if (!size) return size.error();
    DROGUE_TRY(s->cut(*size));
  }
  for (PvdCollection* c : files.collections) {
    const auto count = position(c->file());
    if (!count) return count.error();
    DROGUE_TRY(c->continue_from(*count));
  }
  return {};
}

} // namespace drogue::io
