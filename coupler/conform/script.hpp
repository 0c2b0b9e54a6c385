// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <vector>

#include "coupler/conform/inputs.hpp"
#include "coupler/conform/report.hpp"
#include "coupler/conform/session.hpp"
#include "participant/cpp/protocol_state.hpp"

/// The exchange that every check follows, once as it should be, then disturbed in its own way: Hello,
/// Configure, Initialize, and steps of a few iterates.
namespace drogue::coupler::conform {

inline constexpr int iterations_of_a_step = 2;
inline constexpr int steps = 2;
/// For a participant to end once it was told to.
inline constexpr Seconds end_deadline{10};

/// What the participant did in its undisturbed life.
struct Record {
  v1::Hello hello;
  wire::Message initialized;
  Surface surface;
  /// Answers by step and iteration, both from 0.
  std::vector<std::vector<wire::Message>> answers;
};

/// What a check needs to know.
struct Trial {
  Subject subject;
  Sizes sizes;
  std::vector<std::string> only; ///< promises that are checked; empty: all
  Record record;
};

[[nodiscard]] wire::Message configure(const Trial& trial, const std::filesystem::path& folder,
                                      bool resume = false);
[[nodiscard]] wire::Message initialize();
[[nodiscard]] wire::Message begin_step(const Trial& trial, int step, int attempt = 1);
[[nodiscard]] wire::Message iterate(const Trial& trial, int step, int iteration);
[[nodiscard]] wire::Message commit(int step);
[[nodiscard]] wire::Message rollback(int step);
[[nodiscard]] wire::Message checkpoint(const std::filesystem::path& folder);
[[nodiscard]] wire::Message restore(const std::filesystem::path& folder);
[[nodiscard]] wire::Message replace_mesh(const std::filesystem::path& file);
[[nodiscard]] wire::Message shutdown();
[[nodiscard]] wire::Message abort_run();

/// Asks, and wants that kind of answer. Errors (ErrorKind::peer): what came in place of it.
[[nodiscard]] Result<wire::Message> ask_for(Session& session, wire::Message request,
                                            v1::Envelope::BodyCase answer);
/// Asks, and wants an Error of this code; any code when it is CODE_UNSPECIFIED.
[[nodiscard]] Result<wire::Message> ask_for_error(Session& session, wire::Message request,
                                                  v1::Error::Code code);

/// Waits for Hello.
[[nodiscard]] Result<v1::Hello> hello(Session& session);
/// From the start to a state, with the first step and its iterates where the state asks for them.
[[nodiscard]] Result<void> go_to(Session& session, const Trial& trial, participant::ProtocolState state);
/// BeginStep and the iterates, which must give what the record holds.
[[nodiscard]] Result<void> same_iterates(Session& session, const Trial& trial, int step, int attempt = 1);
/// The same with Commit.
[[nodiscard]] Result<void> same_step(Session& session, const Trial& trial, int step);

/// Errors (ErrorKind::peer): the first difference of two answers, to the bit.
[[nodiscard]] Result<void> same(const wire::Message& expected, const wire::Message& got);
/// The interface holds together; gives its extent.
[[nodiscard]] Result<Surface> surface_of(const wire::Message& initialized);

/// Plays `body` against a new life of the participant and notes whether the first of the promises was kept;
/// the body itself notes the others. Does nothing when none of them is asked for, once the
/// undisturbed life is recorded.
void play(const Trial& trial, Report& report, const std::string& label,
          const std::vector<std::string_view>& promises, const std::function<Result<void>(Session&)>& body,
          int peer_deadline = 600);
/// The processes of `hello` are gone.
void check_orphans(const v1::Hello& hello, Report& report);

/// The checks, in the order in which they are made. The first fills trial.record; false: it could not.
[[nodiscard]] bool check_reference(Trial& trial, Report& report);
void check_requests(const Trial& trial, Report& report);
void check_states(const Trial& trial, Report& report);
void check_endings(const Trial& trial, Report& report);

} // namespace drogue::coupler::conform
