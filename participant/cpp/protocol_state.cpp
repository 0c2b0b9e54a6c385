// SPDX-License-Identifier: GPL-3.0-or-later
#include "participant/cpp/protocol_state.hpp"

#include <array>

namespace drogue::participant {
namespace {

using Body = v1::Envelope;
using enum ProtocolState;

struct Transition {
  ProtocolState from;
  v1::Envelope::BodyCase body;
  ProtocolState to;
};

constexpr std::array transitions{
    Transition{connected, Body::kHello, greeted},     Transition{greeted, Body::kConfigure, configured},
    Transition{configured, Body::kInitialize, ready}, Transition{ready, Body::kBeginStep, in_step},
    Transition{in_step, Body::kIterate, iterated},    Transition{iterated, Body::kIterate, iterated},
    Transition{iterated, Body::kCommit, ready},       Transition{in_step, Body::kRollback, ready},
    Transition{iterated, Body::kRollback, ready},     Transition{ready, Body::kCheckpoint, ready},
    Transition{ready, Body::kRestore, ready},         Transition{ready, Body::kReplaceMesh, ready},
};

} // namespace

std::string_view name(ProtocolState state) {
  switch (state) {
  case connected:
    return "CONNECTED";
  case greeted:
    return "GREETED";
  case configured:
    return "CONFIGURED";
  case ready:
    return "READY";
  case in_step:
    return "IN_STEP";
  case iterated:
    return "ITERATED";
  case failed:
    return "FAILED";
  case finished:
    return "FINISHED";
  }
  return "?";
}

std::string_view name(v1::Envelope::BodyCase body) {
  switch (body) {
  case Body::kHello:
    return "Hello";
  case Body::kBeat:
    return "Beat";
  case Body::kConfigure:
    return "Configure";
  case Body::kInitialize:
    return "Initialize";
  case Body::kBeginStep:
    return "BeginStep";
  case Body::kIterate:
    return "Iterate";
  case Body::kCommit:
    return "Commit";
  case Body::kRollback:
    return "Rollback";
  case Body::kCheckpoint:
    return "Checkpoint";
  case Body::kRestore:
    return "Restore";
  case Body::kShutdown:
    return "Shutdown";
  case Body::kAbort:
    return "Abort";
  case Body::kReplaceMesh:
    return "ReplaceMesh";
  case Body::kReplaced:
    return "Replaced";
  case Body::kDone:
    return "Done";
  case Body::kInitialized:
    return "Initialized";
  case Body::kIterated:
    return "Iterated";
  case Body::kError:
    return "Error";
  case Body::BODY_NOT_SET:
    return "nothing";
  }
  return "?";
}

std::optional<ProtocolState> next_state(ProtocolState from, v1::Envelope::BodyCase body) {
  if (body == Body::kShutdown || body == Body::kAbort) return finished;
  for (const Transition& t : transitions)
    if (t.from == from && t.body == body) return t.to;
  return std::nullopt;
}

} // namespace drogue::participant
