// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/checkpoints.hpp"

#include <thread>

#include <spdlog/spdlog.h>

#include "common/base/hash.hpp"
#include "common/io/atomic_file.hpp"
#include "coupler/run_directory.hpp"

namespace drogue::coupler {
namespace {

namespace fs = std::filesystem;

constexpr const char* request_file = "checkpoint.request";
constexpr const char* state_file = "coupler.state";
constexpr const char* positions_file = "results.state";
constexpr const char* state_kind = "coupler";
constexpr auto request_interval = std::chrono::milliseconds(50);

/// Identifies the interface on which displacements and secants live.
std::string interface_hash(const Participants& participants) {
  Hash hash;
  hash.add(std::span<const double>(participants.structure_interface.points));
  return hash.text();
}

} // namespace

Checkpoints::Checkpoints(const CaseSettings& settings, Participants& participants, StepLoop& loop,
                         Results& results, const fs::path& directory, std::vector<Input> inputs)
    : settings_(settings),
      participants_(participants),
      loop_(loop),
      results_(results),
      directory_(directory),
      store_(directory),
      inputs_(std::move(inputs)) {
  std::error_code ignored;
  fs::remove(directory / request_file, ignored); // of an earlier run
}

bool Checkpoints::due(std::uint64_t step, double time) {
  const CheckpointSettings& s = settings_.checkpoints;
  const double rounding = 1e-9 * settings_.time_step;
  return (s.steps > 0 && step % static_cast<std::uint64_t>(s.steps) == 0) ||
         (s.time > 0 && time >= last_time_ + s.time - rounding) ||
         (s.wall_clock > 0 && Clock::now() - last_at_ >= std::chrono::duration<double>(s.wall_clock));
}

Result<void> Checkpoints::after_step(std::uint64_t step, double time) {
  const bool requested = fs::exists(directory_ / request_file);
  const std::string unable = participants_.who_cannot_checkpoint();
  if (unable.empty() && (requested || due(step, time))) DROGUE_TRY(write(step, time));
  if (!requested) return {};
  if (!unable.empty()) spdlog::warn("a checkpoint was asked for, but {} cannot give one", unable);
  std::error_code failure;
  fs::remove(directory_ / request_file, failure); // the answer
  if (failure) spdlog::warn("cannot remove {}: {}", (directory_ / request_file).string(), failure.message());
  return {};
}

Result<void> Checkpoints::write(std::uint64_t step, double time) {
  if (last_step_ == step) return {};
  const auto start = Clock::now();
  const auto folder = store_.begin(step);
  if (!folder) return folder.error();
  DROGUE_TRY(participants_.checkpoint({step}, *folder));
  DROGUE_TRY(write_own(*folder, step, time));
  DROGUE_TRY(store_.complete(
      {step, time, {settings_.file, settings_.hash}, inputs_, participants_.replaced_mesh()}));
  store_.prune(settings_.checkpoints.keep);
  last_step_ = step;
  last_time_ = time;
  last_at_ = Clock::now();
  spdlog::info("checkpoint of step {} in {} ({:.2f} s)", step, folder->string(),
               std::chrono::duration<double>(last_at_ - start).count());
  return {};
}

Result<void> Checkpoints::write_own(const fs::path& folder, std::uint64_t step, double time) {
  io::State state{state_kind, interface_hash(participants_), time, step, {}};
  loop_.save(state);
  DROGUE_TRY(io::write_state(folder / state_file, state));
  return results_.save_positions(folder / positions_file);
}

Result<void> Checkpoints::take_up(const fs::path& folder, std::uint64_t step,
                                  const std::optional<MeshFile>& mesh) {
  const auto state = io::read_state(folder / state_file);
  if (!state) return state.error();
  if (state->kind != state_kind || state->mesh_hash != interface_hash(participants_))
    return config_error("{} does not belong to the structure's interface: its mesh or its start has changed",
                        (folder / state_file).string());
  if (mesh) {
    const auto change = participants_.replace_mesh({step}, *mesh, true);
    if (!change) return change.error();
  }
  DROGUE_TRY(participants_.restore({step}, folder));
  DROGUE_TRY(loop_.load(*state));
  last_time_ = state->time;
  return {};
}

Result<void> Checkpoints::restore(std::uint64_t step) {
  const auto manifest = store_.read(step);
  if (!manifest) return manifest.error();
  DROGUE_TRY(take_up(store_.folder(step), step, manifest->mesh));
  DROGUE_TRY(results_.restore_positions(store_.folder(step) / positions_file));
  store_.drop_after(step);
  last_step_ = step;
  return {};
}

Result<void> Checkpoints::start_from(const Origin& origin) {
  DROGUE_TRY(take_up(origin.folder, origin.step, origin.mesh));
  loop_.reset_totals();
  return {};
}

Result<std::uint64_t> request_checkpoint(const fs::path& run_directory,
                                         std::chrono::duration<double> deadline) {
  DROGUE_TRY(RunDirectory::check_running(run_directory));
  const fs::path request = run_directory / request_file;
  const CheckpointStore store(run_directory);
  const auto newest = [&] {
    const auto steps = store.steps();
    return steps.empty() ? 0 : steps.back();
  };
  const std::uint64_t before = newest();
  if (const auto asked = io::write_file(request, ""); !asked)
    return Error{ErrorKind::config, asked.error().message};
  const auto end = std::chrono::steady_clock::now() + deadline;
  while (fs::exists(request)) {
    std::this_thread::sleep_for(request_interval);
    const bool running = RunDirectory::check_running(run_directory).ok();
    const bool late = std::chrono::steady_clock::now() > end;
    if (running && !late) continue;
    std::error_code ignored;
    if (!fs::remove(request, ignored)) break; // answered meanwhile
    if (!running) return peer_error("the run in {} ended before the checkpoint", run_directory.string());
    return peer_error("no checkpoint within {:g} s: the step under way did not end", deadline.count());
  }
  if (const std::uint64_t step = newest(); step > before) return step;
  return internal_error("the coupler wrote no checkpoint; {} says why",
                        (run_directory / "coupler.log").string());
}

} // namespace drogue::coupler
