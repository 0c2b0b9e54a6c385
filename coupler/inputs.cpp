// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/inputs.hpp"

#include <algorithm>
#include <fstream>
#include <map>

#include <fmt/format.h>

#include "common/base/hash.hpp"

namespace drogue::coupler {
namespace {

namespace fs = std::filesystem;
using Hashes = std::map<fs::path, std::string>;

std::string content(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

bool is_file(const fs::path& path) {
  std::error_code failure;
  return fs::is_regular_file(path, failure);
}

/// Strings in quotes of a text-format config, comments left out.
std::vector<std::string> quoted(const std::string& text) {
  std::vector<std::string> found;
  char open = 0; // the quote, or #, that is open
  for (const char c : text) {
    if (open == 0 && (c == '"' || c == '\'' || c == '#')) {
      open = c;
      if (c != '#') found.emplace_back();
    } else if (c == open || (open == '#' && c == '\n')) {
      open = 0;
    } else if (open == '"' || open == '\'') {
      found.back() += c;
    }
  }
  return found;
}

/// The hash of a file goes into `hashes`. @return its content
std::string add(const fs::path& file, Hashes& hashes) {
  std::string text = content(file);
  const auto crc = crc32(std::as_bytes(std::span(text.data(), text.size())));
  hashes[file.lexically_normal()] = fmt::format("{:08x}-{}", crc, text.size());
  return text;
}

void add_config(const fs::path& config, Hashes& hashes) {
  for (const std::string& name : quoted(add(config, hashes)))
    if (const fs::path file = config.parent_path() / name; !name.empty() && is_file(file)) add(file, hashes);
}

} // namespace

std::vector<Input> inputs_of(const CaseSettings& settings) {
  Hashes hashes;
  for (const ParticipantSettings* p : participants_of(settings)) {
    if (is_file(p->config)) add_config(p->config, hashes);
    for (const std::string& argument : p->arguments)
      if (fs::path(argument).is_absolute() && is_file(argument)) add(argument, hashes);
  }
  std::vector<Input> inputs;
  for (const auto& [path, hash] : hashes) inputs.push_back({path, hash});
  return inputs;
}

std::vector<std::string> differences(const Manifest& manifest, const CaseSettings& settings) {
  std::vector<std::string> lines;
  if (manifest.case_file.hash != settings.hash)
    lines.push_back(fmt::format("{} has changed", settings.file.string()));
  const std::vector<Input> now = inputs_of(settings);
  const auto among = [](const std::vector<Input>& list, const fs::path& path) {
    return std::any_of(list.begin(), list.end(), [&](const Input& i) { return i.path == path; });
  };
  for (const Input& input : manifest.inputs)
    if (!among(now, input.path))
      lines.push_back(fmt::format("{} is not used, or not there, any more", input.path.string()));
  for (const Input& input : now)
    if (!among(manifest.inputs, input.path))
      lines.push_back(fmt::format("{} is new", input.path.string()));
    else if (std::find(manifest.inputs.begin(), manifest.inputs.end(), input) == manifest.inputs.end())
      lines.push_back(fmt::format("{} has changed", input.path.string()));
  return lines;
}

} // namespace drogue::coupler
