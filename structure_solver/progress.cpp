// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/progress.hpp"

#include <cstdio>
#include <unistd.h>

#include <fmt/core.h>

#include "common/base/log.hpp"

namespace drogue::structure {

Progress::Progress() : terminal_(isatty(STDERR_FILENO) == 1), start_(Clock::now()), last_log_(start_) {}

double Progress::seconds() const {
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

void Progress::show(const Line& line) {
  ++shown_;
  const double cost = seconds() / static_cast<double>(shown_);
  text_ = fmt::format("step {}  t {:.5g}  {} Newton iterations  unbalance {:.2e}  {:.3f} s/step", line.step,
                      line.time, line.iterations, line.unbalance, cost);
  if (line.last_step >= line.step && line.last_step > 0)
    text_ += fmt::format("  {:.0f} s left", cost * static_cast<double>(line.last_step - line.step));
  if (terminal_) {
    fmt::print(stderr, "\r\033[K{}", text_);
    std::fflush(stderr);
  } else if (Clock::now() - last_log_ > std::chrono::seconds(2)) {
    last_log_ = Clock::now();
    spdlog::info(text_);
    text_.clear();
  }
}

void Progress::finish() {
  if (terminal_) fmt::print(stderr, "\r\033[K");
  if (!text_.empty()) spdlog::info(text_);
  text_.clear();
}

} // namespace drogue::structure
