// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/stop.hpp"

#include <atomic>
#include <csignal>
#include <ctime>

#include "coupler/launcher/peer.hpp"

namespace drogue::coupler::stop {
namespace {

std::atomic<bool> orderly_flag{false}, requested_flag{false};
std::atomic<std::time_t> requested_at{0}; ///< seconds

static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<std::time_t>::is_always_lock_free,
              "used in a signal handler");

extern "C" void on_signal(int) {
  timespec now = {};
  clock_gettime(CLOCK_MONOTONIC, &now);
  if (!orderly_flag || (requested_flag && now.tv_sec > requested_at + 1)) {
    launcher::Hub::interrupt();
  } else if (!requested_flag) {
    requested_at = now.tv_sec;
    requested_flag = true;
  }
}

} // namespace

void catch_signals() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  std::signal(SIGPIPE, SIG_IGN);
}

void set_orderly(bool orderly) noexcept {
  orderly_flag = orderly;
}

bool requested() noexcept {
  return requested_flag;
}

} // namespace drogue::coupler::stop
