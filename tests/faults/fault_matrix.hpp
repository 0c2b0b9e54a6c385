// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace drogue::test {

/// A fault, whom it meets, and when; and how the run must end.
struct FaultCase {
  std::string fault, at, victim;
  bool by_proxy = false; ///< flaky_proxy spoils messages; otherwise the participant spoils itself
  int status = 0;        ///< of the coupler; below 0: the signal that killed it
  std::string culprit;   ///< regular expression that the coupler's output must match
  std::string name() const { return victim + "_" + fault + "_" + at; }
};

inline const std::vector<std::string>& all_participants() {
  static const std::vector<std::string> names{"structure", "fluid", "mesh_mover"};
  return names;
}

/// Everything of docs/protocol.md that can go wrong, at every request of every participant.
inline std::vector<FaultCase> fault_matrix() {
  const std::vector<std::string> requests{"Configure", "Initialize", "BeginStep",
                                          "Iterate",   "Commit",     "Checkpoint"};
  std::vector<std::string> with_hello = requests, all = requests;
  with_hello.insert(with_hello.begin(), "Hello");
  all = with_hello;
  all.emplace_back("Shutdown");
  std::vector<FaultCase> cases;
  for (const std::string& v : all_participants()) {
    const std::string who = v + "( \\(pid [0-9]+\\))? ";
    for (const std::string& at : all) {
      cases.push_back({"KILL", at, v, false, 4, who + "was killed by signal 9"});
      cases.push_back({"TERM", at, v, false, 4, who + "was killed by signal 15"});
      cases.push_back({"STOP", at, v, false, 4, who + "did not "});
    }
    for (const std::string& at : with_hello) {
      cases.push_back({"EXIT", at, v, false, 4, who + "exited with status 0"});
      cases.push_back({"DUPLICATE_ANSWER", at, v, true, 0, v + " sent .* again: ignored"});
      cases.push_back({"DELAY_ANSWER", at, v, true, 0, ""});
      cases.push_back({"GARBAGE_TO_COUPLER", at, v, true, 4, "from " + v + ": not a Drogue message"});
    }
    for (const std::string& at : requests) {
      cases.push_back({"DUPLICATE_REQUEST", at, v, true, 0, ""});
      cases.push_back({"DELAY_REQUEST", at, v, true, 0, ""});
      cases.push_back({"GARBAGE_TO_PARTICIPANT", at, v, true, 4, who});
      if (at != "BeginStep" && at != "Iterate")
        cases.push_back({"DISK", at, v, false, 1, v + " refused " + at + ".*No space left"});
    }
    cases.push_back({"ABORT", "destructor", v, false, 4, who + "was killed by signal 6 .* after Shutdown"});
    cases.push_back(
        {"VERSION", "Hello", v, true, 4, v + " speaks protocol versions 2 to 2, the coupler speaks 1"});
    cases.push_back({"MAGIC", "Hello", v, true, 4, "from " + v + ": the peer speaks protocol version 2"});
    cases.push_back({"ANOTHER_ROLE", "Hello", v, false, 4, who + "did not say Hello"});
  }
  for (const std::string& at : all) { // the structure's process strikes at the coupler
    cases.push_back({"COUPLER_KILL", at, "coupler", false, -9, ""});
    cases.push_back({"COUPLER_STOP", at, "coupler", false, 0, ""});
    if (at != "Shutdown") cases.push_back({"COUPLER_TERM", at, "coupler", false, 5, "signal"});
  }
  cases.push_back({"SOCKET", "start", "coupler", false, 1, "cannot listen at"});
  cases.push_back({"PORT", "start", "coupler", false, 2,
                   "cannot listen at tcp://127.0.0.1:[0-9]+: Address already in use"});
  return cases;
}

} // namespace drogue::test
