// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "coupler/launcher/peer.hpp"
#include "coupler/record/record_file.hpp"

namespace drogue::coupler::record {

/// Keeps every message of a run in RUN/record/NAME.record, a file for each participant. After a restart or in
/// a resumed run the next one is NAME.2.record, and so on.
class Recorder : public launcher::Witness {
 public:
  /// @param run_directory where the first free number is looked for
  explicit Recorder(const std::filesystem::path& run_directory);
  Result<void> sent(const std::string& participant, const wire::Frames& frames) override;
  Result<void> received(const std::string& participant, const wire::Frames& frames) override;

 private:
  Result<void> add(const std::string& participant, Direction direction, const wire::Frames& frames);
  std::filesystem::path folder_;
  std::string ending_;
  std::map<std::string, Writer> writers_;
};

} // namespace drogue::coupler::record
