// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace drogue::structure {

/// What a long run shows: one line that rewrites itself on a terminal, a log line every few seconds
/// otherwise.
class Progress {
 public:
  struct Line {
    std::uint64_t step = 0;
    std::uint64_t last_step = 0; ///< 0: not known beforehand
    double time = 0;
    int iterations = 0;
    double unbalance = 0;
  };
  Progress();
  void show(const Line& line);
  /// Ends the rewritten line and logs the last one.
  void finish();
  [[nodiscard]] double seconds() const;

 private:
  using Clock = std::chrono::steady_clock;
  bool terminal_ = false;
  Clock::time_point start_, last_log_;
  std::uint64_t shown_ = 0;
  std::string text_;
};

} // namespace drogue::structure
