// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/interrupt.hpp"

#include <csignal>
#include <ctime>

namespace drogue {
namespace {

volatile std::sig_atomic_t noted = 0;
volatile std::sig_atomic_t noted_at = 0; ///< seconds

extern "C" void note_signal(int signal) {
  timespec now = {};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const auto second = static_cast<std::sig_atomic_t>(now.tv_sec);
  if (!noted) noted_at = second;
  if (noted && second > noted_at + 1) { // delivered when the handler returns
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
  noted = 1;
}

} // namespace

void catch_interrupts() {
  struct sigaction action = {};
  action.sa_handler = note_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() noexcept {
  return noted != 0;
}

} // namespace drogue
