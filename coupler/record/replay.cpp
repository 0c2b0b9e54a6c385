// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/record/replay.hpp"

#include <map>

#include "coupler/conform/script.hpp"
#include "coupler/launcher/peer.hpp"
#include "coupler/record/record_file.hpp"

namespace drogue::coupler {
namespace {

namespace fs = std::filesystem;
using conform::Session;

constexpr int most_differences_printed = 20;

/// One participant, led through a record.
class Player {
 public:
  Player(Session& session, record::Reader& reader) : session_(session), reader_(reader) {}

  Result<void> play() {
    while (true) {
      const auto request = next(record::Direction::to_participant);
      if (!request) return request.error();
      if (!*request) return {};
      DROGUE_TRY(repeat(**request));
    }
  }
  [[nodiscard]] int requests() const { return requests_; }
  [[nodiscard]] int differences() const { return differences_; }

 private:
  /// The next request, or the next answer; nothing at the end. Hello and Beat are not waited for: they come
  /// by themselves.
  Result<std::optional<wire::Message>> next(record::Direction direction) {
    while (true) {
      auto entry = reader_.next();
      if (!entry) return entry.error();
      if (!*entry) return std::optional<wire::Message>();
      const bool by_itself = (**entry).message.envelope.has_beat() || (**entry).message.envelope.has_hello();
      if ((**entry).direction == direction && !by_itself)
        return std::optional<wire::Message>(std::move((**entry).message));
    }
  }

  Result<void> repeat(wire::Message request) {
    v1::Envelope& e = request.envelope;
    e.clear_run_id(); // this life has one of its own
    DROGUE_TRY(move_folders(e));
    const std::string what = launcher::request_text(e.body_case(), e);
    const bool ends = e.has_shutdown() || e.has_abort();
    const auto got = session_.ask(std::move(request));
    if (!got) return got.error();
    ++requests_;
    const auto expected = next(record::Direction::from_participant);
    if (!expected) return expected.error();
    if (!*expected || ends) return {}; // the recorded run ended here
    if (const auto equal = conform::same(**expected, *got);
        !equal && ++differences_ <= most_differences_printed)
      fmt::print("{}: {}\n", what, equal.error().message);
    return {};
  }

  /// What is written goes into the folder of this life.
  Result<void> move_folders(v1::Envelope& e) {
    if (e.has_configure()) e.mutable_configure()->set_directory(session_.folder().string());
    if (e.has_checkpoint()) {
      const fs::path here = session_.folder() / "checkpoints" / std::to_string(checkpoints_.size() + 1);
      std::error_code failure;
      fs::create_directories(here, failure);
      if (failure) return config_error("cannot make the folder {}: {}", here.string(), failure.message());
      checkpoints_[e.checkpoint().directory()] = here;
      e.mutable_checkpoint()->set_directory(here.string());
    }
    if (e.has_restore())
      if (const auto it = checkpoints_.find(e.restore().directory()); it != checkpoints_.end())
        e.mutable_restore()->set_directory(it->second.string());
    return {};
  }

  Session& session_;
  record::Reader& reader_;
  std::map<std::string, fs::path> checkpoints_; ///< here, by their place in the recorded run
  int requests_ = 0, differences_ = 0;
};

/// Which participant a record is of.
Result<std::string> role_of(const fs::path& file) {
  auto reader = record::Reader::open(file);
  if (!reader) return reader.error();
  const auto entry = reader->next();
  if (!entry) return entry.error();
  if (!*entry) return config_error("{} holds no message", file.string());
  return (**entry).message.envelope.participant();
}

} // namespace

Result<void> replay(const ReplayCommand& c) {
  const auto program = launcher::find_program(c.command.at(0));
  if (!program) return program.error();
  const auto role = role_of(c.record);
  if (!role) return role.error();
  auto reader = record::Reader::open(c.record);
  if (!reader) return reader.error();
  conform::Subject subject{c.command, *role, fs::absolute(c.folder), c.deadline};
  subject.command[0] = program->string();
  auto session = Session::start(subject, *role);
  if (!session) return session.error();
  if (const auto said = conform::hello(**session); !said) return said.error();
  Player player(**session, *reader);
  DROGUE_TRY(player.play());
  fmt::print("{}: {} requests, {} answers differ from the record\n", *role, player.requests(),
             player.differences());
  if (player.differences() == 0) return {};
  return peer_error("{} does not answer as it did in the recorded run", c.command[0]);
}

} // namespace drogue::coupler
