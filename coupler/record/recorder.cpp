// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/record/recorder.hpp"

#include <algorithm>

namespace drogue::coupler::record {

namespace fs = std::filesystem;

Recorder::Recorder(const fs::path& run_directory) : folder_(run_directory / "record"), ending_(".record") {
  const auto taken = [&] { // names have no dots
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(folder_, none)) {
      const std::string name = entry.path().filename().string();
      if (name.substr(std::min(name.find('.'), name.size())) == ending_) return true;
    }
    return false;
  };
  for (int life = 2; taken(); ++life) ending_ = fmt::format(".{}.record", life);
}

Result<void> Recorder::sent(const std::string& participant, const wire::Frames& frames) {
  return add(participant, Direction::to_participant, frames);
}

Result<void> Recorder::received(const std::string& participant, const wire::Frames& frames) {
  return add(participant, Direction::from_participant, frames);
}

Result<void> Recorder::add(const std::string& participant, Direction direction, const wire::Frames& frames) {
  auto writer = writers_.find(participant);
  if (writer == writers_.end()) {
    auto made = Writer::create(folder_ / (participant + ending_));
    if (!made) return made.error();
    writer = writers_.emplace(participant, std::move(*made)).first;
  }
  return writer->second.add(direction, frames);
}

} // namespace drogue::coupler::record
