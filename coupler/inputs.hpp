// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "coupler/checkpoint_store.hpp"
#include "coupler/settings.hpp"

namespace drogue::coupler {

/// The files that the participants of a case read, as far as the coupler can know, with hashes of their
/// content: their configs and files among their arguments, and every existing file that stands in quotes in
/// one of these configs (meshes, initial states). Sorted by path, each once.
[[nodiscard]] std::vector<Input> inputs_of(const CaseSettings& settings);

/// A line for each input that changed, disappeared or is new; empty when nothing did.
[[nodiscard]] std::vector<std::string> differences(const Manifest& manifest, const CaseSettings& settings);

} // namespace drogue::coupler
