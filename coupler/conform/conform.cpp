// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/conform/conform.hpp"

#include <cstdlib>

#include "common/io/atomic_file.hpp"
#include "coupler/conform/script.hpp"

namespace drogue::coupler {
namespace {

namespace fs = std::filesystem;
using namespace conform;

/// What its outputs make it.
std::string role_of(const v1::Hello& hello) {
  for (const v1::FieldContract& f : hello.output()) {
    if (f.location() == v1::FieldContract::MESH_NODES) return "mesh_mover";
    if (f.quantity() == v1::FieldContract::PRESSURE || f.quantity() == v1::FieldContract::TRACTION)
      return "fluid";
  }
  return "structure";
}

/// Starts the participant once, to hear what it is.
Result<std::string> ask_for_role(Subject subject) {
  subject.role = "structure";
  auto session = Session::start(subject, "role");
  if (!session) return session.error();
  const auto said = hello(**session);
  if (!said) return said.error();
  return role_of(*said);
}

/// A folder that is removed again, unless the user named one.
class Workplace {
 public:
  static Result<Workplace> make(const fs::path& wanted) {
    if (!wanted.empty()) return Workplace(fs::absolute(wanted), true);
    std::string folder = (fs::temp_directory_path() / "drogue-conform-XXXXXX").string();
    if (!mkdtemp(folder.data())) return config_error("cannot make a folder {}", folder);
    return Workplace(folder, false);
  }
  Workplace(Workplace&& other) noexcept : path_(std::exchange(other.path_, {})), keep_(other.keep_) {}
  Workplace& operator=(Workplace&&) = delete;
  ~Workplace() {
    std::error_code ignored;
    if (!keep_ && !path_.empty()) fs::remove_all(path_, ignored);
  }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  Workplace(fs::path path, bool keep) : path_(std::move(path)), keep_(keep) {}
  fs::path path_;
  bool keep_;
};

} // namespace

Result<void> check_conformance(const ConformCommand& c) {
  const auto program = launcher::find_program(c.command.at(0));
  if (!program) return program.error();
  const auto workplace = Workplace::make(c.folder);
  if (!workplace) return workplace.error();
  Trial trial{{c.command, c.role, workplace->path(), c.deadline}, c.sizes, c.only, {}};
  trial.subject.command[0] = program->string();
  Report report;
  if (c.role.empty()) {
    const auto role = ask_for_role(trial.subject);
    if (role)
      trial.subject.role = *role;
    else
      report.fail("hello", role.error().message);
  }
  if (!trial.subject.role.empty() && check_reference(trial, report)) {
    check_requests(trial, report);
    check_states(trial, report);
    check_endings(trial, report);
  }
  report.restrict_to(c.only);
  fmt::print("{}", report.text());
  if (!c.json.empty())
    if (const auto written = io::write_file(c.json, report.json(c.command, trial.subject.role)); !written)
      return Error{ErrorKind::config, written.error().message};
  if (report.conforms()) return {};
  return peer_error("{} does not keep every promise of the protocol", c.command[0]);
}

} // namespace drogue::coupler
