// SPDX-License-Identifier: GPL-3.0-or-later
// States that are taken back, kept, and given back.
#include <fstream>
#include <map>

#include "coupler/conform/script.hpp"

namespace drogue::coupler::conform {
namespace {

namespace fs = std::filesystem;
using participant::ProtocolState;
using Body = v1::Envelope;

Result<void> roll_back(Session& session, int step) {
  const auto got = ask_for(session, rollback(step), Body::kDone);
  return got ? Result<void>() : got.error();
}

void check_rollback(const Trial& trial, Report& report) {
  if (!trial.record.hello.can_rollback()) return report.skip("rollback", "it says that it cannot roll back");
  play(trial, report, "rollback", {"rollback"}, [&](Session& session) -> Result<void> {
    DROGUE_TRY(go_to(session, trial, ProtocolState::in_step));
    DROGUE_TRY(roll_back(session, 1));
    DROGUE_TRY(same_iterates(session, trial, 1, 2));
    DROGUE_TRY(roll_back(session, 1));
    // Other inputs, so that what is left of them would show.
    if (const auto got = ask_for(session, begin_step(trial, 1, 3), Body::kDone); !got) return got.error();
    if (const auto got = ask_for(session, iterate(trial, 2, 2), Body::kIterated); !got) return got.error();
    DROGUE_TRY(roll_back(session, 1));
    DROGUE_TRY(same_step(session, trial, 1));
    DROGUE_TRY(same_iterates(session, trial, 2));
    DROGUE_TRY(roll_back(session, 2));
    return same_step(session, trial, 2);
  });
}

void check_step_length(const Trial& trial, Report& report) {
  play(trial, report, "step_length", {"step_length"}, [&](Session& session) -> Result<void> {
    DROGUE_TRY(go_to(session, trial, ProtocolState::ready));
    wire::Message half = begin_step(trial, 1);
    half.envelope.mutable_begin_step()->set_time_step(0.5 * trial.sizes.time_step);
    if (!trial.record.hello.variable_step()) {
      const auto refused = ask_for_error(session, std::move(half), v1::Error::UNSUPPORTED);
      return refused ? Result<void>() : refused.error();
    }
    if (const auto got = ask_for(session, std::move(half), Body::kDone); !got) return got.error();
    const auto got = session.ask(iterate(trial, 1, 1));
    if (!got) return got.error();
    if (got->envelope.has_iterated() || got->envelope.error().retryable()) return {};
    return peer_error("Iterate of half a step: Iterated, or a retryable Error expected, got {}",
                      answer_text(*got));
  });
}

Result<fs::path> fresh(const fs::path& folder) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure) return config_error("cannot make the folder {}: {}", folder.string(), failure.message());
  return folder;
}

/// A checkpoint after step 1, and what follows; then step 2 again from the checkpoint. @return the folder of
/// the results, for a life that resumes this one
fs::path check_kept_state(const Trial& trial, Report& report, const fs::path& kept) {
  fs::path results;
  play(trial, report, "checkpoint", {"checkpoint", "restore", "resume"},
       [&](Session& session) -> Result<void> {
         results = session.folder();
         DROGUE_TRY(go_to(session, trial, ProtocolState::ready));
         DROGUE_TRY(same_step(session, trial, 1));
         const auto folder = fresh(kept);
         if (!folder) return folder.error();
         if (const auto got = ask_for(session, checkpoint(kept), Body::kDone); !got) return got.error();
         DROGUE_TRY(same_step(session, trial, 2));
         const auto again = [&]() -> Result<void> {
           if (const auto got = ask_for(session, restore(kept), Body::kDone); !got) return got.error();
           return same_step(session, trial, 2);
         }();
         if (again)
           report.pass("restore");
         else
           report.fail("restore", again.error().message);
         return {};
       });
  return results;
}

std::map<fs::path, std::string> contents(const fs::path& folder) {
  std::map<fs::path, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    std::ifstream stream(entry.path(), std::ios::binary);
    if (entry.is_regular_file() && entry.path().filename() != "log.txt")
      files[entry.path()] = {std::istreambuf_iterator<char>(stream), {}};
  }
  return files;
}

/// A life that resumes and ends before Restore leaves the results alone.
void check_resume_cut_short(const Trial& trial, Report& report, const fs::path& results) {
  play(trial, report, "resume_cut_short", {"resume"}, [&](Session& session) -> Result<void> {
    const auto before = contents(results);
    if (const auto said = hello(session); !said) return said.error();
    if (const auto got = ask_for(session, configure(trial, results, true), Body::kDone); !got)
      return got.error();
    if (const auto got = ask_for(session, initialize(), Body::kInitialized); !got) return got.error();
    if (const auto sent = session.send(abort_run()); !sent) return sent.error();
    if (const auto exit = session.end(end_deadline); !exit) return exit.error();
    const auto after = contents(results);
    for (const auto& [file, text] : before)
      if (!after.count(file) || after.at(file) != text)
        return peer_error("aborted before Restore, it changed {}", file.filename().string());
    return {};
  });
}

void check_resume(const Trial& trial, Report& report, const fs::path& kept, const fs::path& results) {
  play(trial, report, "resume", {"resume"}, [&](Session& session) -> Result<void> {
    if (const auto said = hello(session); !said) return said.error();
    if (const auto got = ask_for(session, configure(trial, results, true), Body::kDone); !got)
      return got.error();
    const auto initialized = ask_for(session, initialize(), Body::kInitialized);
    if (!initialized) return initialized.error();
    DROGUE_TRY(same(trial.record.initialized, *initialized));
    if (const auto got = ask_for(session, restore(kept), Body::kDone); !got) return got.error();
    return same_step(session, trial, 2);
  });
}

void check_bad_checkpoint(const Trial& trial, Report& report, const fs::path& kept) {
  std::error_code unreadable;
  if (fs::is_empty(kept, unreadable)) return report.skip("bad_checkpoint", "its checkpoint holds no file");
  play(trial, report, "bad_checkpoint", {"bad_checkpoint"}, [&](Session& session) -> Result<void> {
    DROGUE_TRY(go_to(session, trial, ProtocolState::ready));
    const auto nothing = fresh(trial.subject.folder / "empty");
    if (!nothing) return nothing.error();
    const auto got = ask_for_error(session, restore(*nothing), v1::Error::CODE_UNSPECIFIED);
    if (!got) return got.error();
    const auto exit = session.end(end_deadline);
    if (!exit) return exit.error();
    return exit->status != 0 && exit->signal == 0 ? Result<void>() : peer_error("it {}", exit->text());
  });
}

/// It either cannot replace its mesh, and says so, or has no such file.
void check_bad_mesh(const Trial& trial, Report& report) {
  play(trial, report, "bad_mesh", {"bad_mesh"}, [&](Session& session) -> Result<void> {
    DROGUE_TRY(go_to(session, trial, ProtocolState::ready));
    const bool can = trial.record.hello.can_replace_mesh();
    const auto got = ask_for_error(session, replace_mesh(session.folder() / "none.msh"),
                                   can ? v1::Error::CODE_UNSPECIFIED : v1::Error::UNSUPPORTED);
    if (!got) return got.error();
    const auto exit = session.end(end_deadline);
    if (!exit) return exit.error();
    return exit->status != 0 && exit->signal == 0 ? Result<void>() : peer_error("it {}", exit->text());
  });
}

} // namespace

void check_states(const Trial& trial, Report& report) {
  check_rollback(trial, report);
  check_step_length(trial, report);
  check_bad_mesh(trial, report);
  if (!trial.record.hello.can_checkpoint()) {
    for (const char* promise : {"checkpoint", "restore", "resume", "bad_checkpoint"})
      report.skip(promise, "it says that it cannot give checkpoints");
    return;
  }
  const fs::path kept = trial.subject.folder / "kept";
  const fs::path results = check_kept_state(trial, report, kept);
  check_resume_cut_short(trial, report, results);
  check_resume(trial, report, kept, results);
  check_bad_checkpoint(trial, report, kept);
}

} // namespace drogue::coupler::conform
