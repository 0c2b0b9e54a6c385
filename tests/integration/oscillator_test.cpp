// SPDX-License-Identifier: GPL-3.0-or-later
// Whole coupled runs of four processes whose answer is known: the oscillator of oscillator_participant.cpp.
#include <cmath>
#include <functional>
#include <thread>

#include "coupler/launcher/process.hpp"
#include "tests/support/coupled_case.hpp"

namespace drogue::test {
namespace {

int run_coupler(const std::filesystem::path& case_file, const std::string& command = "run") {
  auto process =
      launcher::Process::start({{std::string(DROGUE_BIN_DIR) + "/coupler", command, case_file.string()},
                                {},
                                case_file.parent_path(),
                                case_file.parent_path() / "output.txt"});
  if (!process) return -1;
  const auto& exit = process->wait(std::chrono::seconds(60));
  return exit ? exit->status : -1;
}

/// Displacement since the start after each step of the trapezoidal rule for (m + m_a) a + k d = f(t).
std::vector<double> oscillator(
    int steps, double dt, double v = 0,
    const std::function<double(double)>& force = [](double) { return 0.0; }) {
  const double mass = 5.5, k = 40, d0 = 0.01;
  double d = d0, a = -k * d / mass;
  std::vector<double> history;
  for (int n = 0; n < steps; ++n) {
    const double guess = d + dt * v + 0.25 * dt * dt * a;
    const double a1 = (force((n + 1) * dt) - k * guess) / (mass + 0.25 * dt * dt * k);
    d = guess + 0.25 * dt * dt * a1;
    v += 0.5 * dt * (a + a1);
    a = a1;
    history.push_back(d - d0);
  }
  return history;
}

TEST(Oscillator, FollowsTheMonolithicSolutionWithTenfoldAddedMass) {
  const auto folder = fresh_folder("iqn");
  ASSERT_EQ(run_coupler(write_case(folder, {.steps = 20, .extra = "loop { relative: 1e-9 }"})), 0)
      << read_text(folder / "output.txt");
  const Table drag = read_csv(folder / "run/drag.csv"), coupling = read_csv(folder / "run/coupling.csv");
  const auto exact = oscillator(20, 0.02);
  ASSERT_EQ(drag.rows.size(), 20u);
  for (std::size_t n = 0; n < exact.size(); ++n)
    EXPECT_NEAR(drag.at(n, "mean_displacement_z"), exact[n], 1e-8 * 0.01) << "step " << n + 1;
  for (std::size_t i = 0; i < coupling.rows.size(); ++i) {
    EXPECT_LT(coupling.at(i, "force_defect"), 1e-12);
    // Both sides see the same work: flat surfaces, and a motion that either carries exactly.
    EXPECT_NEAR(coupling.at(i, "power_structure"), coupling.at(i, "power_fluid"),
                1e-10 * (1 + std::abs(coupling.at(i, "power_fluid"))));
    for (const char* component : {"_x", "_y", "_z"})
      EXPECT_NEAR(coupling.at(i, std::string("moment_structure") + component),
                  coupling.at(i, std::string("moment_fluid") + component), 1e-10);
    EXPECT_LT(coupling.at(i, "displacement_defect"), 1e-10);
  }
  EXPECT_GT(std::abs(coupling.at(1, "power_fluid")), 1e-6);
}

/// The flow's first load is that of the initial acceleration, m_a a_0; what is withheld of it acts as a force
/// of its own, and the added mass stays whole.
TEST(Oscillator, WithholdsTheFirstLoadWithoutWeakeningTheInertia) {
  const auto folder = fresh_folder("withheld");
  ASSERT_EQ(run_coupler(write_case(
                folder, {.steps = 20,
                         .extra = "loop { relative: 1e-9 } withheld_first_load: \"max(0, 1 - t/0.2)\""})),
            0)
      << read_text(folder / "output.txt");
  const Table drag = read_csv(folder / "run/drag.csv");
  const double first_load = 5 * (-40 * 0.01 / 5.5);
  const auto exact =
      oscillator(20, 0.02, 0, [&](double t) { return -std::max(0.0, 1 - t / 0.2) * first_load; });
  ASSERT_EQ(drag.rows.size(), 20u);
  for (std::size_t n = 0; n < exact.size(); ++n)
    EXPECT_NEAR(drag.at(n, "mean_displacement_z"), exact[n], 1e-8 * 0.01) << "step " << n + 1;
  EXPECT_NEAR(drag.at(4, "withheld_first_load"), 0.5, 1e-12);
}

/// The same in a plane problem: lines with three nodes on the structure, with two on the fluid, forces per
/// unit depth.
TEST(Oscillator, OnLinesFollowsTheSameSolution) {
  const auto folder = fresh_folder("lines");
  const std::string plane = "--plane yes";
  ASSERT_EQ(run_coupler(write_case(folder, {.structure_arguments = plane,
                                            .fluid_arguments = plane,
                                            .mesh_mover_arguments = plane,
                                            .steps = 10,
                                            .extra = "loop { relative: 1e-9 }"})),
            0)
      << read_text(folder / "output.txt");
  const Table drag = read_csv(folder / "run/drag.csv"), coupling = read_csv(folder / "run/coupling.csv");
  const auto exact = oscillator(10, 0.02);
  ASSERT_EQ(drag.rows.size(), 10u);
  for (std::size_t n = 0; n < exact.size(); ++n)
    EXPECT_NEAR(drag.at(n, "mean_displacement_y"), exact[n], 1e-8 * 0.01) << "step " << n + 1;
  for (std::size_t i = 0; i < coupling.rows.size(); ++i) EXPECT_LT(coupling.at(i, "force_defect"), 1e-12);
}

TEST(Oscillator, SmallConstantRelaxationConvergesToTheSame) {
  const auto folder = fresh_folder("constant");
  ASSERT_EQ(run_coupler(write_case(folder, {.steps = 3,
                                            .extra = "acceleration { method: CONSTANT relaxation: 0.1 }"
                                                     "loop { relative: 1e-7 max_iterations: 400 }"})),
            0)
      << read_text(folder / "output.txt");
  EXPECT_NEAR(read_csv(folder / "run/drag.csv").at(2, "mean_displacement_z"), oscillator(3, 0.02)[2],
              1e-7 * 0.01);
}

/// Structure first, fluid and structure at the same time, and the multi-vector Jacobian: the same solution.
TEST(Oscillator, EverySchemeFollowsTheSameSolution) {
  const auto exact = oscillator(12, 0.02);
  for (const std::string scheme : {"SERIAL", "PARALLEL", "STRUCTURE_FIRST"})
    for (const std::string method : {"IQN_ILS", "IQN_IMVJ"}) {
      const auto folder = fresh_folder(scheme + method);
      ASSERT_EQ(run_coupler(write_case(
                    folder, {.steps = 12,
                             .extra = "loop { relative: 1e-8 max_iterations: 400 stall: 0 scheme: " + scheme +
                                      " } acceleration { method: " + method + " }"})),
                0)
          << read_text(folder / "output.txt");
      const Table drag = read_csv(folder / "run/drag.csv");
      ASSERT_EQ(drag.rows.size(), 12u);
      for (std::size_t n = 0; n < exact.size(); ++n)
        EXPECT_NEAR(drag.at(n, "mean_displacement_z"), exact[n], 1e-7 * 0.01)
            << scheme << " " << method << n + 1;
    }
}

/// From a start whose displacement and velocity do not belong together.
TEST(Oscillator, AitkenConvergesFromAnExtrapolatedStart) {
  const auto folder = fresh_folder("aitken_predicted");
  ASSERT_EQ(run_coupler(write_case(folder, {.steps = 10,
                                            .extra = "acceleration { method: AITKEN } "
                                                     "loop { relative: 1e-7 predictor: 2 }"})),
            0)
      << read_text(folder / "output.txt");
  EXPECT_NEAR(read_csv(folder / "run/drag.csv").at(9, "mean_displacement_z"), oscillator(10, 0.02)[9],
              1e-6 * 0.01);
}

/// One factor does where the load alone is accelerated; the added mass is seen from that side as well.
TEST(Oscillator, StructureFirstConvergesByAitkenAndWarnsOfTheAddedMass) {
  const auto folder = fresh_folder("aitken");
  ASSERT_EQ(run_coupler(write_case(folder, {.steps = 4,
                                            .extra = "acceleration { method: AITKEN } loop { relative: 1e-8 "
                                                     "predictor: 2 scheme: STRUCTURE_FIRST }"})),
            0)
      << read_text(folder / "output.txt");
  EXPECT_NEAR(read_csv(folder / "run/drag.csv").at(3, "mean_displacement_z"), oscillator(4, 0.02)[3], 1e-9);
  EXPECT_NE(read_text(folder / "output.txt").find("answers with about 9.9"), std::string::npos)
      << read_text(folder / "output.txt");
}

/// Criteria of other fields beside that of the displacement: all must hold.
TEST(Oscillator, EveryCriterionGivenMustHold) {
  const auto last_change = [](const std::string& criteria, const std::string& column) {
    const auto folder = fresh_folder("criteria");
    EXPECT_EQ(
        run_coupler(write_case(
            folder, {.steps = 1,
                     .extra = "acceleration { method: CONSTANT relaxation: 0.05 } loop { relative: 0.5 " +
                              criteria + " }"})),
        0)
        << read_text(folder / "output.txt");
    const Table coupling = read_csv(folder / "run/coupling.csv");
    return coupling.at(coupling.rows.size() - 1, column);
  };
  EXPECT_GT(last_change("", "load_change"), 1e-7);
  EXPECT_LE(last_change("load_relative: 1e-7", "load_change"), 1e-7);
  EXPECT_GT(last_change("", "velocity_residual"), 1e-7);
  EXPECT_LE(last_change("velocity_relative: 1e-7", "velocity_residual"), 1e-7);
  const double alone = last_change("", "residual_absolute");
  EXPECT_LT(last_change("residual_relative: 1e-6", "residual_absolute"), 1e-3 * alone);
}

/// A relaxation at which the residual neither grows much nor falls.
TEST(Oscillator, AStalledIterationStartsAnewAndThenEnds) {
  const auto folder = fresh_folder("stall");
  ASSERT_EQ(run_coupler(write_case(folder, {.steps = 1,
                                            .extra = "acceleration { method: CONSTANT relaxation: 0.182 }"
                                                     "loop { max_iterations: 60 stall: 5 }"})),
            3);
  const std::string output = read_text(folder / "output.txt");
  EXPECT_NE(output.find("the accelerator starts anew"), std::string::npos) << output;
  EXPECT_NE(output.find("the residual stalls at"), std::string::npos) << output;
  EXPECT_LT(read_csv(folder / "run/coupling.csv").rows.size(), 20u);
}

TEST(Oscillator, NonConvergenceAbortsWithStatusThreeAndKeepsWhatIsWritten) {
  const auto folder = fresh_folder("abort");
  ASSERT_EQ(run_coupler(write_case(folder, {.extra = "acceleration { method: CONSTANT relaxation: 1 }"
                                                     "loop { max_iterations: 4 divergence: 1e9 }"})),
            3);
  EXPECT_NE(read_text(folder / "output.txt").find("step 1 (t = 0.02, length 0.02) did not converge"),
            std::string::npos);
  EXPECT_EQ(read_csv(folder / "run/coupling.csv").rows.size(), 4u);
}

TEST(Oscillator, AcceptedStepsAreCountedAsNotConverged) {
  const auto folder = fresh_folder("accept");
  ASSERT_EQ(run_coupler(write_case(folder, {.steps = 2,
                                            .extra = "acceleration { method: CONSTANT relaxation: 0.1 }"
                                                     "loop { max_iterations: 2 non_convergence: ACCEPT }"})),
            0);
  EXPECT_NE(read_text(folder / "output.txt").find("2 not converged"), std::string::npos);
  EXPECT_EQ(read_csv(folder / "run/drag.csv").at(0, "converged"), 0);
}

TEST(Oscillator, ARefusedStepIsDoneInHalves) {
  const auto folder = fresh_folder("retry");
  ASSERT_EQ(run_coupler(write_case(folder, {.fluid_arguments = "--refuse-steps-above 0.012",
                                            .steps = 3,
                                            .extra = "loop { relative: 1e-9 non_convergence: RETRY }"})),
            0)
      << read_text(folder / "output.txt");
  const Table drag = read_csv(folder / "run/drag.csv");
  const auto exact = oscillator(6, 0.01);
  ASSERT_EQ(drag.rows.size(), 6u);
  for (std::size_t n = 0; n < 6; ++n) EXPECT_NEAR(drag.at(n, "mean_displacement_z"), exact[n], 1e-8 * 0.01);
  EXPECT_NE(read_text(folder / "output.txt").find(" 3 steps (done in 6 parts), "), std::string::npos)
      << read_text(folder / "output.txt");
}

TEST(Oscillator, TheSecantsOfTheFullStepOutliveAStepInHalves) {
  const auto folder = fresh_folder("secants");
  ASSERT_EQ(run_coupler(write_case(folder, {.fluid_arguments = "--refuse-step 3",
                                            .steps = 4,
                                            .extra = "loop { non_convergence: RETRY }"})),
            0)
      << read_text(folder / "output.txt");
  const Table coupling = read_csv(folder / "run/coupling.csv");
  std::vector<double> first; // secants used after the first iteration of each attempt
  for (std::size_t i = 0; i < coupling.rows.size(); ++i)
    if (coupling.at(i, "iteration") == 1) first.push_back(coupling.at(i, "columns"));
  EXPECT_EQ(first, (std::vector<double>{0, 1, 0, 1, 1})); // steps 1, 2, the halves of 3, and 4
}

TEST(Oscillator, StartsWithTheVelocityOfTheStructure) {
  const auto folder = fresh_folder("velocity");
  ASSERT_EQ(run_coupler(write_case(
                folder,
                {.structure_arguments = "--velocity 0.05", .steps = 10, .extra = "loop { relative: 1e-9 }"})),
            0)
      << read_text(folder / "output.txt");
  const Table drag = read_csv(folder / "run/drag.csv");
  const auto exact = oscillator(10, 0.02, 0.05);
  for (std::size_t n = 0; n < exact.size(); ++n)
    EXPECT_NEAR(drag.at(n, "mean_displacement_z"), exact[n], 1e-8 * 0.01) << "step " << n + 1;
}

/// The plate converges in its second iterate; the fluid says for three that it has not.
TEST(Oscillator, AStepDoesNotEndBeforeTheSolversOwnIterations) {
  const auto folder = fresh_folder("inner");
  const auto iterations = [&](const std::string& arguments, const std::string& loop) {
    const auto status = run_coupler(write_case(
        folder, {.fluid_arguments = arguments, .steps = 1, .extra = "loop { relative: 0.5 " + loop + "}"}));
    EXPECT_EQ(status, 0) << read_text(folder / "output.txt");
    return read_csv(folder / "run/drag.csv").at(0, "iterations");
  };
  const double free = iterations("", "");
  ASSERT_LT(free, 4);
  EXPECT_EQ(iterations("--fixed-residual 0.2", ""), 4);
  EXPECT_EQ(iterations("--fixed-residual 0.2", "inner_residual: 0.3 "), free);
  EXPECT_EQ(iterations("--fixed-residual 0.05", ""), free);
}

TEST(Oscillator, AnUnconvergedSolverIsNamedWhenTheIterationsRunOut) {
  const auto folder = fresh_folder("inner");
  ASSERT_EQ(run_coupler(write_case(folder, {.fluid_arguments = "--fixed-residual 0.2",
                                            .extra = "loop { relative: 0.5 max_iterations: 3 }"})),
            3);
  EXPECT_NE(read_text(folder / "output.txt").find("the fluid's own iteration did not converge"),
            std::string::npos);
}

/// No file of the run may grow beyond a few kB: the table of iterations meets that limit first.
TEST(Oscillator, AFullDiskEndsTheRunAndNamesTheFile) {
  const auto folder = fresh_folder("full");
  const auto file = write_case(folder, {.steps = 200});
  auto process = launcher::Process::start({{"/bin/sh", "-c", "trap '' XFSZ; ulimit -f 16; exec \"$@\"", "sh",
                                            std::string(DROGUE_BIN_DIR) + "/coupler", "run", file.string()},
                                           {},
                                           folder,
                                           folder / "output.txt"});
  ASSERT_TRUE(process.ok());
  const auto& exit = process->wait(std::chrono::seconds(60));
  ASSERT_TRUE(exit.has_value());
  const std::string output = read_text(folder / "output.txt");
  EXPECT_EQ(exit->status, 1) << output;
  EXPECT_NE(output.find("cannot write " + (folder / "run/coupling.csv").string()), std::string::npos)
      << output;
  EXPECT_GT(read_csv(folder / "run/coupling.csv").rows.size(), 10u);
}

TEST(Oscillator, ASecondRunInTheSameFolderIsRefused) {
  const auto folder = fresh_folder("lock");
  const auto file = write_case(folder, {.fluid_arguments = "--delay 0.2", .steps = 100});
  auto first = launcher::Process::start(
      {{std::string(DROGUE_BIN_DIR) + "/coupler", "run", file.string()}, {}, folder, folder / "first.txt"});
  ASSERT_TRUE(first.ok());
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!std::filesystem::exists(folder / "run/drag.csv") && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(run_coupler(file), 2);
  EXPECT_NE(
      read_text(folder / "output.txt").find(fmt::format("another coupler (pid {}) runs in", first->pid())),
      std::string::npos)
      << read_text(folder / "output.txt");
  EXPECT_TRUE(std::filesystem::exists(folder / "run/drag.csv"));
  EXPECT_FALSE(std::filesystem::exists(folder / "run.1"));
  first->kill_session();
  EXPECT_EQ(run_coupler(write_case(folder, {.steps = 1})), 0) << "the lock of a dead coupler holds";
}

TEST(Oscillator, AnEarlierRunIsKeptAside) {
  const auto folder = fresh_folder("aside");
  const auto file = write_case(folder, {.steps = 1});
  ASSERT_EQ(run_coupler(file), 0);
  ASSERT_EQ(run_coupler(file), 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "run.1/drag.csv"));
  EXPECT_TRUE(std::filesystem::exists(folder / "run/drag.csv"));
}

TEST(Oscillator, AnInconsistentPairOfRateAndLoadIsRefused) {
  const auto folder = fresh_folder("pair");
  ASSERT_EQ(run_coupler(write_case(folder, {.extra = "loop { wall_velocity: MESH_RATE }"})), 2);
  EXPECT_NE(read_text(folder / "output.txt").find("MESH_RATE"), std::string::npos);
}

/// What does not fit is refused before the first step, and named; what is not a number ends the run.
TEST(Oscillator, MistakesOfTheParticipantsAreNamed) {
  const auto output_of = [](const OscillatorCase& c, int status) {
    const auto folder = fresh_folder("mistake");
    EXPECT_EQ(run_coupler(write_case(folder, c)), status);
    return read_text(folder / "output.txt");
  };
  const std::string apart = output_of({.structure_arguments = "--mistake apart"}, 2);
  EXPECT_NE(apart.find("largest_gap"), std::string::npos) << apart;
  const std::string quantity = output_of({.structure_arguments = "--mistake quantity"}, 2);
  EXPECT_NE(
      quantity.find("structure: input \"force\" is declared as TRACTION at INTERFACE_NODES, 3 components, "
                    "END_OF_STEP; the coupler has FORCE"),
      std::string::npos)
      << quantity;
  const std::string nan = output_of({.fluid_arguments = "--mistake nan"}, 3);
  EXPECT_NE(nan.find("output \"pressure\" is not finite at node 3, component 0"), std::string::npos) << nan;
}

/// A solver that knows `check FILE` and nothing else of us: no option, no DROGUE_PARTICIPANT.
TEST(Check, RunsAForeignSolversCheckAsTheLaunchWould) {
  const auto folder = fresh_folder("foreign");
  const auto solver = folder / "solver.sh";
  std::ofstream(solver)
      << "#!/bin/sh\n"
         "[ $# -eq 2 ] && [ \"$1\" = check ] || exit 2\n"
         "[ -z \"$(ls -A)\" ] || { echo \"$(pwd) is not empty\"; exit 2; }\n"
         "echo \"$DROGUE_PARTICIPANT $COLOUR $OMP_NUM_THREADS\" >> \"$(dirname $2)/seen\"\n";
  std::filesystem::permissions(solver, std::filesystem::perms::owner_all);
  std::ofstream(folder / "settings") << "red = 3\n";
  const auto file = folder / "case.textproto";
  std::ofstream stream(file);
  stream << "name: 'foreign' run_directory: 'run' time { step: 1 steps: 1 }\n";
  for (const char* role : {"structure", "mesh_mover", "fluid"})
    stream << role << " { command: '${config_dir}/solver.sh' config: 'settings' environment: 'COLOUR=" << role
           << "' environment: 'OMP_NUM_THREADS=3' }\n";
  stream.close();
  EXPECT_EQ(run_coupler(file, "check"), 0) << read_text(folder / "output.txt");
  EXPECT_EQ(read_text(folder / "seen"), "fluid fluid 3\nstructure structure 3\nmesh_mover mesh_mover 3\n");
  EXPECT_FALSE(std::filesystem::exists(folder / "run"));
}

} // namespace
} // namespace drogue::test
