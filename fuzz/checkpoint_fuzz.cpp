// SPDX-License-Identifier: GPL-3.0-or-later
// What a checkpoint is read from. The first byte picks: a state file, or the manifest. A state that is read
// is written and read again, the same.
#include <cstdlib>

#include "common/base/hash.hpp"
#include "common/io/state_file.hpp"
#include "coupler/checkpoint_store.hpp"
#include "fuzz/scratch_file.hpp"

namespace {

using namespace drogue;

void read_state(const std::uint8_t* data, std::size_t size) {
  const auto state = io::read_state(fuzz::put("fuzz.state", data, size));
  if (!state) return;
  const auto again = fuzz::scratch_folder() / "again.state";
  if (!io::write_state(again, *state)) std::abort();
  const auto second = io::read_state(again);
  if (!second || second->arrays.size() != state->arrays.size()) std::abort();
}

/// With the seal that the writer puts under a manifest: the text itself is what is to be read.
void read_manifest(const std::uint8_t* data, std::size_t size) {
  std::string text(reinterpret_cast<const char*>(data), size);
  text += fmt::format("# crc32: {:08x}\n", crc32(std::as_bytes(std::span(text.data(), text.size()))));
  const coupler::CheckpointStore store(fuzz::scratch_folder());
  std::filesystem::create_directories(store.folder(1));
  fuzz::put(store.folder(1).lexically_relative(fuzz::scratch_folder()) / "manifest.textproto",
            reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  (void)store.read(1);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  (data[0] % 2 == 0 ? read_state : read_manifest)(data + 1, size - 1);
  return 0;
}
