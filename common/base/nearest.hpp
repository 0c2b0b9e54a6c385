// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace drogue {

/// The candidate with the smallest edit distance to `word`, for "did you mean"; empty when none is near
/// (distance above a third of the longer word, at least 2).
[[nodiscard]] std::string nearest_name(std::string_view word, std::span<const std::string> candidates);

} // namespace drogue
