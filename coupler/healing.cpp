// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/healing.hpp"

#include <spdlog/spdlog.h>

#include "coupler/inputs.hpp"
#include "coupler/launcher/peer.hpp"
#include "coupler/stop.hpp"

namespace drogue::coupler {

Healing::Healing(const CaseSettings& settings, const std::filesystem::path& directory)
    : settings_(settings), directory_(directory) {
  if (settings.restarts > 0) inputs_ = inputs_of(settings);
}

std::optional<Start> Healing::after(const Error& error) {
  if (settings_.restarts == 0 || error.kind != ErrorKind::peer || !error.retryable) return std::nullopt;
  if (stop::requested() || launcher::Hub::interrupted()) return std::nullopt;
  if (restarts_ == settings_.restarts) {
    spdlog::warn("no restart is left of the {} that healing.restarts allows", settings_.restarts);
    return std::nullopt;
  }
  if (inputs_of(settings_) != inputs_) {
    spdlog::warn("no restart: a config or a mesh has changed since the run began");
    return std::nullopt;
  }
  const Start start = newest_start();
  spdlog::warn("{}", error.message);
  spdlog::warn("restart {} of at most {}: every participant is started again, the run goes on {}",
               ++restarts_, settings_.restarts,
               start.resumed ? fmt::format("after step {}", start.step) : "from its start");
  return start;
}

Start Healing::newest_start() const {
  const CheckpointStore store(directory_);
  if (store.steps().empty()) return {};
  if (const auto manifest = store.newest_whole()) return {manifest->step, true};
  store.drop_after(0);
  return {};
}

} // namespace drogue::coupler
