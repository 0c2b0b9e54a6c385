// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <unistd.h>

namespace drogue::fuzz {

/// A folder in memory, one a process, for readers that want a file.
inline const std::filesystem::path& scratch_folder() {
  static const std::filesystem::path folder = [] {
    std::string name = "/dev/shm/drogue-fuzz-XXXXXX";
    if (!mkdtemp(name.data())) std::abort();
    std::atexit([] { std::filesystem::remove_all(scratch_folder()); });
    return std::filesystem::path(name);
  }();
  return folder;
}

/// Puts bytes into a file of that folder.
inline std::filesystem::path put(const std::string& name, const std::uint8_t* data, std::size_t size) {
  const std::filesystem::path file = scratch_folder() / name;
  std::FILE* stream = std::fopen(file.c_str(), "wb");
  if (!stream || std::fwrite(data, 1, size, stream) != size) std::abort();
  std::fclose(stream);
  return file;
}

} // namespace drogue::fuzz
