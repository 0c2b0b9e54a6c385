// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/checkpoint_store.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>

#include <fcntl.h>
#include <fmt/ranges.h>
#include <google/protobuf/text_format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "common/base/hash.hpp"
#include "common/io/atomic_file.hpp"
#include "drogue/v1/checkpoint.pb.h"

namespace drogue::coupler {
namespace {

namespace fs = std::filesystem;

constexpr const char* manifest_file = "manifest.textproto";
constexpr std::string_view seal = "# crc32: ";
constexpr std::uint32_t manifest_version = 1;

std::uint32_t checksum(std::string_view text) {
  return crc32(std::as_bytes(std::span(text.data(), text.size())));
}

Result<std::string> content(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) return config_error("{} cannot be read", file.string());
  return text;
}

/// A participant's own program may not have done so.
Result<void> bring_to_disk(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = descriptor >= 0 && (fsync(descriptor) == 0 || errno == EINVAL);
  const int reason = errno;
  if (descriptor >= 0) close(descriptor);
  if (!synced)
    return internal_error("cannot bring {} onto the disk: {}", path.string(), std::strerror(reason));
  return {};
}

Result<void> add_files(const fs::path& folder, v1::CheckpointManifest& manifest) {
  std::vector<fs::path> files;
  std::error_code failure;
  for (const auto& entry : fs::recursive_directory_iterator(folder, failure)) {
    DROGUE_TRY(bring_to_disk(entry.path()));
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  if (failure) return internal_error("cannot list {}: {}", folder.string(), failure.message());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    const auto text = content(file);
    if (!text) return internal_error("{}", text.error().message);
    v1::CheckpointManifest::File& entry = *manifest.add_file();
    entry.set_path(file.lexically_relative(folder).generic_string());
    entry.set_size(text->size());
    entry.set_crc32(checksum(*text));
  }
  return {};
}

Result<void> put_mesh(const MeshFile& mesh, const fs::path& run_directory,
                      v1::CheckpointManifest::MeshFile& to) {
  const auto text = content(mesh.path);
  if (!text) return internal_error("{}", text.error().message);
  to.set_path(mesh.path.lexically_relative(run_directory).generic_string());
  to.set_mesh_hash(mesh.mesh_hash);
  to.set_size(text->size());
  to.set_crc32(checksum(*text));
  return bring_to_disk(mesh.path);
}

void put(const Input& input, v1::CheckpointManifest::Input& to) {
  to.set_path(input.path.string());
  to.set_hash(input.hash);
}

Result<v1::CheckpointManifest> parse(const fs::path& file) {
  const auto text = content(file);
  if (!text) return text.error();
  const std::size_t end = text->rfind(seal);
  if (end == std::string::npos ||
      text->substr(end) != fmt::format("{}{:08x}\n", seal, checksum(text->substr(0, end))))
    return config_error("{} was cut short or altered", file.string());
  v1::CheckpointManifest manifest;
  if (!google::protobuf::TextFormat::ParseFromString(*text, &manifest))
    return config_error("{} cannot be decoded", file.string());
  if (manifest.version() != manifest_version)
    return config_error("{} has version {}; this program reads version {}", file.string(), manifest.version(),
                        manifest_version);
  return manifest;
}

/// Of the checkpoint, or a mesh of the run.
template <class File>
Result<void> check_file(const fs::path& folder, const File& file) {
  const fs::path inside = fs::path(file.path()).lexically_normal();
  if (inside.empty() || inside.is_absolute() || *inside.begin() == "..")
    return config_error("{}: the manifest names \"{}\", which is no file of the checkpoint", folder.string(),
                        file.path());
  const fs::path path = folder / inside;
  std::error_code failure;
  const auto size = fs::file_size(path, failure);
  if (failure) return config_error("{}: {}", path.string(), failure.message());
  if (size != file.size())
    return config_error("{} has {} bytes in place of {}", path.string(), size, file.size());
  const auto text = content(path);
  if (!text) return text.error();
  if (checksum(*text) != file.crc32())
    return config_error("{} was altered: its checksum is wrong", path.string());
  return {};
}

} // namespace

fs::path CheckpointStore::folder(std::uint64_t step) const {
  return root_ / fmt::format("{:08}", step);
}

bool CheckpointStore::is_complete(std::uint64_t step) const {
  return fs::exists(folder(step) / manifest_file);
}

std::vector<std::uint64_t> CheckpointStore::folders() const {
  std::vector<std::uint64_t> found;
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(root_, failure)) {
    const std::string name = entry.path().filename();
    std::uint64_t step = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), step);
    if (error == std::errc{} && entry.path() == folder(step)) found.push_back(step);
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<std::uint64_t> CheckpointStore::steps() const {
  std::vector<std::uint64_t> found = folders();
  std::erase_if(found, [&](std::uint64_t step) { return !is_complete(step); });
  return found;
}

Result<fs::path> CheckpointStore::begin(std::uint64_t step) const {
  remove(step);
  std::error_code failure;
  fs::create_directories(folder(step), failure);
  if (failure)
    return internal_error("cannot make the folder {}: {}", folder(step).string(), failure.message());
  return folder(step);
}

Result<void> CheckpointStore::complete(const Manifest& manifest) const {
  v1::CheckpointManifest m;
  m.set_version(manifest_version);
  m.set_step(manifest.step);
  m.set_time(manifest.time);
  put(manifest.case_file, *m.mutable_case_file());
  for (const Input& input : manifest.inputs) put(input, *m.add_input());
  if (manifest.mesh) DROGUE_TRY(put_mesh(*manifest.mesh, root_.parent_path(), *m.mutable_mesh()));
  DROGUE_TRY(add_files(folder(manifest.step), m));
  DROGUE_TRY(bring_to_disk(folder(manifest.step)));
  std::string text;
  google::protobuf::TextFormat::PrintToString(m, &text);
  text += fmt::format("{}{:08x}\n", seal, checksum(text));
  return io::write_file(folder(manifest.step) / manifest_file, text);
}

Result<Manifest> CheckpointStore::read(std::uint64_t step) const {
  const auto m = parse(folder(step) / manifest_file);
  if (!m) return m.error();
  if (m->step() != step)
    return config_error("{} is of step {}", (folder(step) / manifest_file).string(), m->step());
  for (const auto& file : m->file()) DROGUE_TRY(check_file(folder(step), file));
  Manifest manifest{m->step(), m->time(), {m->case_file().path(), m->case_file().hash()}, {}};
  if (m->has_mesh()) {
    DROGUE_TRY(check_file(root_.parent_path(), m->mesh()));
    manifest.mesh = {root_.parent_path() / m->mesh().path(), m->mesh().mesh_hash()};
  }
  for (const auto& input : m->input()) manifest.inputs.push_back({input.path(), input.hash()});
  return manifest;
}

Result<Manifest> CheckpointStore::newest_whole(const std::optional<std::uint64_t>& wanted) const {
  std::vector<std::uint64_t> all = steps();
  const std::string run = root_.parent_path().string();
  if (all.empty()) return config_error("{} holds no checkpoint", run);
  if (wanted && std::find(all.begin(), all.end(), *wanted) == all.end())
    return config_error("{} holds no checkpoint of step {}; there are those of steps {}", run, *wanted,
                        fmt::join(all, ", "));
  for (; !all.empty(); all.pop_back()) {
    if (wanted && all.back() > *wanted) continue;
    auto manifest = read(all.back());
    if (manifest) return manifest;
    spdlog::warn("the checkpoint of step {} is not used: {}", all.back(), manifest.error().message);
  }
  return config_error("{} holds no checkpoint that is whole", run);
}

void CheckpointStore::prune(int keep) const {
  const std::vector<std::uint64_t> complete = steps(), all = folders();
  if (complete.empty()) return;
  const std::size_t kept = std::min(complete.size(), static_cast<std::size_t>(keep));
  const std::uint64_t oldest = complete[complete.size() - kept];
  for (const std::uint64_t step : all)
    if (step < oldest || (step < complete.back() && !is_complete(step))) remove(step);
}

void CheckpointStore::drop_after(std::uint64_t step) const {
  for (const std::uint64_t later : folders()) {
    if (later <= step) continue;
    remove(later);
    spdlog::info("the checkpoint of step {}, after the one in use, is removed", later);
  }
}

/// The manifest first: what a removal that is cut short leaves is not complete.
void CheckpointStore::remove(std::uint64_t step) const {
  std::error_code failure;
  fs::remove(folder(step) / manifest_file, failure);
  fs::remove_all(folder(step), failure);
  if (failure) spdlog::warn("cannot remove {}: {}", folder(step).string(), failure.message());
}

} // namespace drogue::coupler
