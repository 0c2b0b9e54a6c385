// SPDX-License-Identifier: GPL-3.0-or-later
// Coupled runs whose processes are killed at random: the solvers, which the coupler starts again, and the
// coupler itself, which is continued by `coupler resume`. All results must be those of the undisturbed run,
// to the bit. Environment: DROGUE_KILLS solvers are killed (default 100) with the random numbers of
// DROGUE_SEED (1); of the quick T-10 DROGUE_STEPS steps are done (60).
#include <algorithm>
#include <cstdlib>

#include "tests/support/processes.hpp"
#include "tests/support/t10_quick.hpp"
#include "tests/support/verify.hpp"

namespace drogue::test {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

int number(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text ? std::atoi(text) : otherwise;
}

/// Results of folder/killed, and files of its checkpoint of step `last`, that are not those of
/// folder/undisturbed.
int differing(const fs::path& folder, int last) {
  const auto a = everything(folder / "undisturbed", last);
  if (!has_checkpoint(folder / "killed", last)) return static_cast<int>(a.size());
  const auto b = everything(folder / "killed", last);
  int count = 0;
  for (const auto& [name, text] : a) count += b.count(name) && b.at(name) == text ? 0 : 1;
  for (const auto& [name, text] : b) count += a.count(name) ? 0 : 1;
  return count;
}

bool holds_a_checkpoint(const fs::path& run) {
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(run / "checkpoints", none))
    if (fs::exists(entry.path() / "manifest.textproto")) return true;
  return false;
}

struct Kills {
  int solvers = 0, couplers = 0, orphans = 0, status = -1;
};

/// Runs folder/FILE, whose run is folder/killed/run. Between two kills pass 0 to 2 `mean`; every tenth is one
/// of the coupler.
Kills disturbed_run(const fs::path& folder, const std::string& file, int wanted, Seconds mean,
                    unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> pause(0, 2 * mean.count());
  Kills kills;
  launcher::Process coupler = start_program(folder, {"run", file});
  while (!coupler.wait(std::chrono::milliseconds(static_cast<int>(1000 * pause(random))))) {
    if (kills.solvers == wanted) continue;
    if (kills.solvers < 9 * (kills.couplers + 1)) {
      kills.solvers += kill_a_participant(coupler.pid(), folder / "killed", random) ? 1 : 0;
      continue;
    }
    ++kills.couplers;
    kill(coupler.pid(), SIGKILL);
    (void)coupler.wait(std::chrono::seconds(10));
    if (!eventually([&] { return left_behind(folder / "killed") == 0; }, 15)) ++kills.orphans;
    const bool begun = holds_a_checkpoint(folder / "killed/run");
    coupler = begun ? start_program(folder, {"resume", "killed/run"}) : start_program(folder, {"run", file});
  }
  kills.status = coupler.poll()->status;
  kills.orphans += left_behind(folder / "killed");
  if (kills.status != 0) ADD_FAILURE() << read_text(folder / "output.txt");
  return kills;
}

void report(const std::string& name, const Kills& kills, int wanted, int differences) {
  verify(name, "solvers_killed", kills.solvers, wanted, 0);
  verify(name, "couplers_killed", kills.couplers, wanted / 10, 1 + wanted / 50);
  verify(name, "exit_status", kills.status, 0, 0);
  verify(name, "orphans", kills.orphans, 0, 0);
  verify(name, "files_that_differ", differences, 0, 0);
}

TEST(ParticipantsKills, Oscillator) {
  const int wanted = number("DROGUE_KILLS", 100);
  const auto folder = fresh_folder("runs");
  OscillatorCase c{.structure_arguments = "--delay 0.002",
                   .fluid_arguments = "--refuse-step 3 --delay 0.002",
                   .steps = 5 * wanted,
                   .extra = "loop { predictor: 2 non_convergence: RETRY } checkpoints { steps: 3 }"
                            "healing { restarts: 1000000 }"};
  for (const char* name : {"undisturbed", "killed"}) {
    fs::create_directories(folder / name);
    write_case(folder / name, c);
  }
  ASSERT_EQ(run_coupler_with(folder, {"run", "undisturbed/case.textproto"}), 0);
  const int last = 3 * (c.steps / 3);
  ASSERT_TRUE(has_checkpoint(folder / "undisturbed", last));
  const Kills kills = disturbed_run(folder, "killed/case.textproto", wanted, Seconds(0.25),
                                    static_cast<unsigned>(number("DROGUE_SEED", 1)));
  report("participants/oscillator", kills, wanted, differing(folder, last));
}

TEST_F(T10Quick, ParticipantsKills) {
  const int wanted = number("DROGUE_KILLS", 100), steps = number("DROGUE_STEPS", 60);
  prepare();
  change("case.textproto", "steps: 60 }",
         fmt::format("steps: {} }} checkpoints {{ steps: 1 }} healing {{ restarts: 1000000 }}", steps));
  change("case.textproto", "\"coupled\"", "\"undisturbed/run\"");
  const auto start = Clock::now();
  run("coupler", "run", "case.textproto", std::chrono::minutes(40));
  const Seconds a_step = (Clock::now() - start) / steps;
  change("case.textproto", "undisturbed/run", "killed/run");
  const Kills kills = disturbed_run(folder_, "case.textproto", wanted, 2.25 * a_step,
                                    static_cast<unsigned>(number("DROGUE_SEED", 1)));
  report("participants/t10_quick", kills, wanted, differing(folder_, steps));
}

} // namespace
} // namespace drogue::test
