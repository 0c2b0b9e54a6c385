// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/conform/report.hpp"

#include <algorithm>
#include <array>
#include <cassert>

namespace drogue::coupler::conform {
namespace {

struct Promise {
  std::string_view name, text;
};

/// In the order of the report. docs/protocol.md lists them too.
constexpr std::array promises{
    Promise{"hello", "says Hello once, by itself, before the deadline"},
    Promise{"version", "speaks version 1 of the protocol"},
    Promise{"identity", "every message carries the run, its own name and the number of the request"},
    Promise{"processes", "Hello names its processes, and they live"},
    Promise{"contract", "its fields are complete, have names of their own, and are those of its role"},
    Promise{"initialize", "gives an interface that holds together"},
    Promise{"iterate", "gives every output of its contract, in its shape, finite"},
    Promise{"deterministic", "the same sequence of requests in another process: the same answers to the bit"},
    Promise{"wrong_state", "a request that does not fit the state: Error WRONG_STATE, nothing changes"},
    Promise{"missing_input", "an Iterate without a required input: Error BAD_MESSAGE"},
    Promise{"bad_shape", "an input of a wrong shape: Error BAD_MESSAGE"},
    Promise{"not_finite", "an input that holds NaN: Error NOT_FINITE, which names the field"},
    Promise{"wrong_run", "a request of another run: Error BAD_MESSAGE"},
    Promise{"refusals", "refused requests change nothing"},
    Promise{"repeat", "a repeated request: the same answer again, nothing computed"},
    Promise{"pause", "a request after a pause is answered as any other"},
    Promise{"rollback", "Rollback gives back the state at BeginStep to the bit"},
    Promise{"step_length", "takes a step of another length, or refuses it as it said"},
    Promise{"checkpoint", "Checkpoint changes nothing"},
    Promise{"restore", "Restore gives back the state at the checkpoint to the bit"},
    Promise{"resume", "so does Restore in a new process with Configure.resume"},
    Promise{"bad_checkpoint",
            "Restore from a folder without its files: an Error, and an end with another status than 0"},
    Promise{"bad_mesh", "ReplaceMesh with a file that is not there, or to one that cannot: an Error, and "
                        "another status than 0"},
    Promise{"beats", "Beat about once a second while it works"},
    Promise{"version_refused", "Configure with an unknown version: Error UNSUPPORTED, and status 2"},
    Promise{"malformed", "a malformed message is not taken for a request"},
    Promise{"shutdown", "Shutdown in every state: Done, and an end with status 0"},
    Promise{"abort", "Abort in every state: an end with another status than 0"},
    Promise{"coupler_death", "the coupler disappears: an end with status 4 within ten seconds"},
    Promise{"silence", "the coupler is silent beyond DROGUE_PEER_DEADLINE: an end with status 4"},
    Promise{"orphans", "after its end none of its processes is left"},
};

std::string_view word(Verdict verdict) {
  switch (verdict) {
  case Verdict::passed:
    return "pass";
  case Verdict::failed:
    return "FAIL";
  case Verdict::not_applicable:
    return "skip";
  case Verdict::not_reached:
    return "not reached";
  }
  return "?";
}

std::string json_text(std::string_view text) {
  std::string q = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      q += {'\\', c};
    else if (static_cast<unsigned char>(c) < 0x20)
      q += fmt::format("\\u{:04x}", c);
    else
      q += c;
  }
  return q + '"';
}

} // namespace

Finding& Report::at(std::string_view promise) {
  const auto it =
      std::find_if(promises.begin(), promises.end(), [&](const Promise& p) { return p.name == promise; });
  assert(it != promises.end());
  return findings_[it->name];
}

Finding Report::found(std::string_view promise) const {
  const auto it = findings_.find(promise);
  return it == findings_.end() ? Finding{} : it->second;
}

void Report::pass(std::string_view promise) {
  if (Finding& f = at(promise); f.verdict != Verdict::failed) f = {Verdict::passed, ""};
}

void Report::fail(std::string_view promise, const std::string& detail) {
  if (Finding& f = at(promise); f.verdict != Verdict::failed) f = {Verdict::failed, detail};
}

void Report::skip(std::string_view promise, const std::string& why) {
  if (Finding& f = at(promise); f.verdict == Verdict::not_reached) f = {Verdict::not_applicable, why};
}

void Report::restrict_to(const std::vector<std::string>& only) {
  for (const Promise& p : promises)
    if (!only.empty() && std::find(only.begin(), only.end(), p.name) == only.end() &&
        found(p.name).verdict == Verdict::not_reached)
      skip(p.name, "not asked for");
}

std::vector<std::string> Report::names() {
  std::vector<std::string> all;
  for (const Promise& p : promises) all.emplace_back(p.name);
  return all;
}

bool Report::conforms() const {
  return std::all_of(promises.begin(), promises.end(), [&](const Promise& p) {
    const Verdict v = found(p.name).verdict;
    return v == Verdict::passed || v == Verdict::not_applicable;
  });
}

std::string Report::text() const {
  std::string lines;
  std::array<int, 4> counts{};
  for (const Promise& p : promises) {
    const Finding f = found(p.name);
    ++counts[static_cast<std::size_t>(f.verdict)];
    lines += fmt::format("{:<12}{:<16} {}\n", word(f.verdict), p.name, p.text);
    if (!f.detail.empty()) lines += fmt::format("{:<28} {}\n", "", f.detail);
  }
  return fmt::format("{}{} passed, {} failed, {} do not apply, {} not reached: {}\n", lines, counts[0],
                     counts[1], counts[2], counts[3], conforms() ? "it conforms" : "it does not conform");
}

std::string Report::json(const std::vector<std::string>& command, const std::string& role) const {
  std::string words;
  for (const std::string& w : command) words += (words.empty() ? "" : ", ") + json_text(w);
  std::string list;
  for (const Promise& p : promises) {
    const Finding f = found(p.name);
    list += fmt::format("{}\n    {{\"name\": {}, \"promise\": {}, \"verdict\": {}, \"detail\": {}}}",
                        list.empty() ? "" : ",", json_text(p.name), json_text(p.text),
                        json_text(word(f.verdict)), json_text(f.detail));
  }
  return fmt::format(
      "{{\n  \"command\": [{}],\n  \"role\": {},\n  \"conforms\": {},\n  \"promises\": [{}\n  ]\n}}\n", words,
      json_text(role), conforms(), list);
}

} // namespace drogue::coupler::conform
