// SPDX-License-Identifier: GPL-3.0-or-later
// Two hosts: two network namespaces with addresses of their own and a bad line between them (tests/support/
// lossy_link.cpp: 10 ms each way, 1 % of the packets lost). The coupler, the structure and the mesh mover of
// the quick T-10 run on one, the fluid on the other, with CURVE keys; the results are those of the run on one
// machine, to the bit. Needs root and a kernel with namespaces and tunnels; is skipped without.
#include <csignal>

#include "tests/support/t10_quick.hpp"
#include "tests/support/verify.hpp"

namespace drogue::test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr int coupled_steps = 3;
constexpr const char *coupler_address = "10.77.0.1", *fluid_address = "10.77.0.2";

class TwoHosts : public T10Quick {
 protected:
  void SetUp() override {
    if (geteuid() != 0) GTEST_SKIP() << "network namespaces need root";
    T10Quick::SetUp();
    if (!shell("ip netns add " + near_) || !shell("ip netns add " + far_))
      GTEST_SKIP() << "no network namespaces here: " << read_text(folder_ / "shell.txt");
    auto line = launcher::Process::start({{std::string(DROGUE_TEST_BIN_DIR) + "/lossy_link", near_,
                                           coupler_address, far_, fluid_address, "10", "1"},
                                          {},
                                          folder_,
                                          folder_ / "line.txt"});
    ASSERT_TRUE(line.ok());
    line_ = std::move(*line);
    const bool up = eventually([&] { return line_->poll() || !read_text(folder_ / "line.txt").empty(); });
    if (!up || line_->poll()) GTEST_SKIP() << "no tunnel devices here: " << read_text(folder_ / "line.txt");
  }
  void TearDown() override {
    line_.reset();
    (void)shell("ip netns del " + near_);
    (void)shell("ip netns del " + far_);
  }
  bool shell(const std::string& command) {
    auto process = launcher::Process::start({{"/bin/sh", "-c", command}, {}, folder_, folder_ / "shell.txt"});
    if (!process) return false;
    const auto& exit = process->wait(20s);
    return exit && exit->clean();
  }
  launcher::Process start_on(const std::string& host, const std::string& command, const std::string& log) {
    auto process = launcher::Process::start(
        {{"/bin/sh", "-c", "exec ip netns exec " + host + " " + command}, {}, folder_, folder_ / log});
    EXPECT_TRUE(process.ok());
    return std::move(*process);
  }

  std::string near_ = fmt::format("drogue-{}-a", getpid()), far_ = fmt::format("drogue-{}-b", getpid());
  std::optional<launcher::Process> line_;
};

TEST_F(TwoHosts, TheQuickCaseOverABadLineIsThatOnOneMachine) {
  prepare();
  change("case.textproto", "steps: 60 }", fmt::format("steps: {} }}", coupled_steps));
  change("case.textproto", "\"coupled\"", "\"one/run\"");
  run("coupler", "run", "case.textproto");

  ASSERT_EQ(run_coupler_with(folder_, {"keygen", "coupler", "fluid"}), 0);
  change("case.textproto", "one/run", "two/run");
  change("case.textproto", "config: \"fluid.textproto\"",
         "config: \"fluid.textproto\" launch: NONE public_key: \"fluid.pub\"");
  std::ofstream(folder_ / "case.textproto", std::ios::app)
      << "network { endpoint: 'tcp://" << coupler_address << ":5555' key: 'coupler.key' }\n";
  const auto begin = std::chrono::steady_clock::now();
  launcher::Process coupler =
      start_on(near_, std::string(DROGUE_BIN_DIR) + "/coupler run case.textproto", "coupler.txt");
  const std::regex printed("^env .*DROGUE_PARTICIPANT=fluid .*$", std::regex::multiline);
  std::smatch match;
  std::string text;
  ASSERT_TRUE(eventually([&] {
    return text = read_text(folder_ / "coupler.txt"), std::regex_search(text, match, printed);
  })) << text;
  const std::string command =
      std::regex_replace(match.str(), std::regex(" fluid_solver "), " " DROGUE_BIN_DIR "/fluid_solver ");
  launcher::Process fluid = start_on(far_, command, "fluid.txt");
  const auto coupler_exit = coupler.wait(10min), fluid_exit = fluid.wait(20s);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  ASSERT_TRUE(coupler_exit && coupler_exit->clean()) << read_text(folder_ / "coupler.txt");
  EXPECT_TRUE(fluid_exit && fluid_exit->clean()) << read_text(folder_ / "fluid.txt");

  int differing = 0;
  for (const char* file : {"drag.csv", "coupling.csv", "structure/structure.pvd", "fluid/forces.csv"})
    differing += read_text(folder_ / "one/run" / file) != read_text(folder_ / "two/run" / file) ? 1 : 0;
  fmt::print("{} steps over the line in {:.0f} s; {}\n", coupled_steps, seconds,
             launcher::last_lines(folder_ / "line.txt", 1).back());
  const std::string name = "participants/two_hosts";
  verify(name, "steps_done", static_cast<double>(read_csv(folder_ / "two/run/drag.csv").rows.size()),
         coupled_steps, 0);
  verify(name, "files_that_differ", differing, 0, 0);
}

} // namespace
} // namespace drogue::test
