// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>

#include <sys/prctl.h>
#include <unistd.h>

#include "participant/cpp/participant.hpp"

namespace drogue::test {

/// What goes wrong, and at which request; an empty kind is none. Of the requests that come again and again,
/// the fault strikes in step 3, and with the checkpoint of step 4.
///   KILL STOP TERM      the signal, to this process
///   EXIT                ends with status 0
///   DISK                cannot write
///   COUPLER_KILL COUPLER_TERM   the signal, to the coupler
///   COUPLER_STOP        SIGSTOP to the coupler, SIGCONT half a second later
struct Fault {
  std::string kind, at;

  [[nodiscard]] Result<void> strike() const {
    if (kind == "KILL") std::raise(SIGKILL);
    if (kind == "STOP") std::raise(SIGSTOP);
    if (kind == "TERM") std::raise(SIGTERM);
    if (kind == "EXIT") std::_Exit(0);
    if (kind == "COUPLER_KILL") ::kill(getppid(), SIGKILL);
    if (kind == "COUPLER_TERM") ::kill(getppid(), SIGTERM);
    if (kind == "COUPLER_STOP") stop_for_a_while(getppid());
    if (kind == "DISK") {
      std::ofstream full("/dev/full");
      full << "a result" << std::flush;
      if (!full) return internal_error("cannot write: No space left on device");
    }
    return {};
  }

 private:
  static void stop_for_a_while(pid_t pid) {
    if (fork() != 0) return;
    ::kill(pid, SIGSTOP);
    usleep(500'000);
    ::kill(pid, SIGCONT);
    std::_Exit(0);
  }
};

/// A solver that meets a fault in one of its calls; what it passes on is untouched.
class FaultySolver : public participant::Solver {
 public:
  FaultySolver(std::unique_ptr<participant::Solver> inner, Fault fault)
      : inner_(std::move(inner)), fault_(std::move(fault)) {}

  participant::Description describe() override {
    (void)meet("Hello");
    return inner_->describe();
  }
  Result<void> configure(const participant::RunInfo& run) override {
    DROGUE_TRY(meet("Configure"));
    return inner_->configure(run);
  }
  Result<participant::InterfaceMesh> initialize() override {
    DROGUE_TRY(meet("Initialize"));
    return inner_->initialize();
  }
  Result<void> begin_step(const participant::StepInfo& step) override {
    step_ = step.step;
    if (step_ >= 3) DROGUE_TRY(meet("BeginStep"));
    return inner_->begin_step(step);
  }
  Result<participant::IterationReport> iterate(const participant::Fields& in,
                                               participant::Fields& out) override {
    if (step_ >= 3) DROGUE_TRY(meet("Iterate"));
    return inner_->iterate(in, out);
  }
  Result<void> commit(bool write_output) override {
    if (step_ >= 3) DROGUE_TRY(meet("Commit"));
    return inner_->commit(write_output);
  }
  Result<void> rollback() override { return inner_->rollback(); }
  Result<void> checkpoint(const std::filesystem::path& directory) override {
    if (step_ >= 4) DROGUE_TRY(meet("Checkpoint"));
    return inner_->checkpoint(directory);
  }
  Result<void> restore(const std::filesystem::path& directory) override { return inner_->restore(directory); }

 private:
  [[nodiscard]] Result<void> meet(const char* request) {
    if (fault_.at != request) return {};
    fault_.at.clear(); // once
    return fault_.strike();
  }
  std::unique_ptr<participant::Solver> inner_;
  Fault fault_;
  std::uint64_t step_ = 0;
};

} // namespace drogue::test
