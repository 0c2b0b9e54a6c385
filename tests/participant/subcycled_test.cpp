// SPDX-License-Identifier: GPL-3.0-or-later
// A mass on a spring in smaller steps than those of the coupling: against the same solver that takes the
// small steps itself, and against the exact motion.
#include "participant/cpp/subcycled.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>

#include <gtest/gtest.h>
#include <unistd.h>

namespace drogue::participant {
namespace {

using C = v1::FieldContract;
using Force = std::function<double(double)>;

/// d'' + 4 d = f by the trapezoidal rule. Outputs: d, and its mean over the step as the rule sees it.
class Spring : public PartedSolver {
 public:
  Description describe() override {
    Description d;
    d.inputs = {field("force", C::FORCE, C::INTERFACE_NODES, 1)};
    d.outputs = {field("d", C::DISPLACEMENT, C::INTERFACE_NODES, 1),
                 field("mean_d", C::DISPLACEMENT, C::INTERFACE_NODES, 1, C::MEAN_OF_STEP)};
    return d;
  }
  Result<void> configure(const RunInfo&) override { return {}; }
  Result<InterfaceMesh> initialize() override { return InterfaceMesh{}; }
  Result<void> begin_step(const StepInfo& step) override {
    EXPECT_NEAR(step.time, n_.t, 1e-12);
    dt_ = step.time_step;
    return {};
  }
  Result<IterationReport> iterate(const Fields& in, Fields& out) override {
    ++calls;
    if (fails_at == calls) return retryable_error("not this time");
    const double f = in.at("force").values[0], h = dt_;
    const double guess = n_.d + h * n_.v + 0.25 * h * h * n_.a;
    now_.a = (f - 4 * guess) / (1 + h * h);
    now_.d = guess + 0.25 * h * h * now_.a;
    now_.v = n_.v + 0.5 * h * (n_.a + now_.a);
    now_.t = n_.t + h;
    out["d"] = {{1, 1}, {now_.d}};
    out["mean_d"] = {{1, 1}, {0.5 * (n_.d + now_.d)}};
    return IterationReport{1, 0, true};
  }
  Result<void> commit(bool) override {
    n_ = now_;
    start_.reset();
    return {};
  }
  Result<void> rollback() override { return {}; }
  Result<void> end_part() override {
    if (!start_) start_ = n_;
    n_ = now_;
    return {};
  }
  Result<void> undo_parts() override {
    if (start_) n_ = *start_;
    start_.reset();
    return {};
  }
  Result<void> checkpoint(const std::filesystem::path& directory) override {
    std::ofstream stream(directory / "spring", std::ios::binary);
    stream.write(reinterpret_cast<const char*>(&n_), sizeof n_);
    return {};
  }
  Result<void> restore(const std::filesystem::path& directory) override {
    std::ifstream stream(directory / "spring", std::ios::binary);
    stream.read(reinterpret_cast<char*>(&n_), sizeof n_);
    return {};
  }
  int calls = 0, fails_at = 0;

 private:
  struct Motion {
    double d = 0, v = 0, a = 0, t = 0;
  };
  Motion n_, now_;
  std::optional<Motion> start_;
  double dt_ = 0;
};

Fields force_of(double value) {
  return {{"force", {{1, 1}, {value}}}};
}

/// One step of the coupling, in `iterates` iterations of which only the last is given the true force.
Fields step(Solver& solver, std::uint64_t number, double t, double dt, const Force& f, int iterates = 1) {
  Fields out;
  EXPECT_TRUE(solver.begin_step({number, 1, t, dt}).ok());
  for (int k = iterates; k-- > 0;) EXPECT_TRUE(solver.iterate(force_of(f(t + dt) + 7.0 * k), out).ok());
  EXPECT_TRUE(solver.commit(false).ok());
  return out;
}

/// d after `steps` steps in the time T; with `parts` of each.
double motion(const Force& f, double T, int steps, int parts, Interpolation interpolation, int iterates = 1) {
  Spring spring;
  Subcycled in_parts(spring, parts, interpolation);
  (void)in_parts.describe();
  double d = 0;
  for (int k = 0; k < steps; ++k)
    d = step(in_parts, static_cast<std::uint64_t>(k) + 1, T * k / steps, T / steps, f, iterates)
            .at("d")
            .values[0];
  return d;
}

/// A force that the interpolation has exactly: as if the solver had taken the small steps itself. Iterations
/// before the last leave nothing behind.
TEST(Subcycled, DoesWhatTheSolverDoesInSmallSteps) {
  const Force line = [](double t) { return t < 0.25 ? 1 : 0.5 + 2 * t; };
  const Force parabola = [](double t) { return 1 + 2 * t + (t < 0.5 ? 0 : 4 * (t - 0.25) * (t - 0.5)); };
  // In the first step an input is constant, with a quadratic the second step has a line.
  EXPECT_NEAR(motion(line, 2, 8, 5, Interpolation::linear, 3), motion(line, 2, 40, 1, Interpolation::linear),
              1e-13);
  const Force from_first = [&](double t) { return t < 0.25 ? 1.5 : parabola(t); };
  EXPECT_NEAR(motion(from_first, 2, 8, 5, Interpolation::quadratic, 2),
              motion(from_first, 2, 40, 1, Interpolation::linear), 1e-13);
  EXPECT_GT(std::abs(motion(from_first, 2, 8, 5, Interpolation::linear) -
                     motion(from_first, 2, 40, 1, Interpolation::linear)),
            1e-4);
}

/// Against d'' + 4 d = t^4 from rest, d = t^4/4 - 3 t^2/4 + 3/8 (1 - cos 2t). With small parts the
/// interpolation's error alone is left: of second order, or with the quadratic of third.
TEST(Subcycled, ConvergesWithTheOrderOfTheInterpolation) {
  const Force f = [](double t) { return t * t * t * t; };
  const auto error = [&](int steps, Interpolation interpolation) {
    return std::abs(motion(f, 2, steps, 2000 / steps, interpolation) - (4 - 3 + 0.375 * (1 - std::cos(4.0))));
  };
  const auto order = [&](Interpolation i) { return std::log2(error(10, i) / error(20, i)); };
  EXPECT_NEAR(order(Interpolation::linear), 2, 0.3);
  EXPECT_GT(order(Interpolation::quadratic), 2.5);
  EXPECT_LT(error(20, Interpolation::quadratic), 0.2 * error(20, Interpolation::linear));
}

TEST(Subcycled, GivesTheLastPartAndTheMeanOfAll) {
  Spring whole, parted;
  Subcycled in_parts(parted, 2, Interpolation::linear);
  (void)in_parts.describe();
  const Force one = [](double) { return 1.0; };
  const double first = step(whole, 1, 0, 0.1, one).at("mean_d").values[0];
  const double second = step(whole, 2, 0.1, 0.1, one).at("mean_d").values[0];
  EXPECT_DOUBLE_EQ(step(in_parts, 1, 0, 0.2, one).at("mean_d").values[0], 0.5 * (first + second));
}

/// X_start goes with X: a part has the values at its own ends.
TEST(Subcycled, LeadsAnInputFromItsStartToItsEnd) {
  class Listener : public Spring {
   public:
    Result<IterationReport> iterate(const Fields& in, Fields& out) override {
      heard.push_back({in.at("velocity_start").values[0], in.at("velocity").values[0]});
      return Spring::iterate(in, out);
    }
    std::vector<std::pair<double, double>> heard;
  };
  Listener listener;
  Subcycled in_parts(listener, 4, Interpolation::quadratic);
  Fields in = force_of(0), out;
  in["velocity_start"] = {{1, 1}, {1}};
  in["velocity"] = {{1, 1}, {3}};
  ASSERT_TRUE(in_parts.begin_step({1, 1, 0, 1}).ok());
  ASSERT_TRUE(in_parts.iterate(in, out).ok());
  ASSERT_EQ(listener.heard.size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_DOUBLE_EQ(listener.heard[k].first, 1 + 0.5 * static_cast<double>(k));
    EXPECT_DOUBLE_EQ(listener.heard[k].second, 1.5 + 0.5 * static_cast<double>(k));
  }
}

/// A failure in a later part, a rollback, a shorter step, and a checkpoint: the steps after are the same to
/// the bit.
TEST(Subcycled, RollsBackAndResumes) {
  const Force f = [](double t) { return std::cos(3 * t); };
  const auto folder =
      std::filesystem::temp_directory_path() / ("drogue_subcycled_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  Spring spring, other, third;
  Subcycled smooth(spring, 3, Interpolation::quadratic), disturbed(other, 3, Interpolation::quadratic),
      resumed(third, 3, Interpolation::quadratic);
  for (std::uint64_t k = 1; k <= 2; ++k) {
    const double t = 0.2 * static_cast<double>(k - 1);
    EXPECT_EQ(step(smooth, k, t, 0.2, f).at("d").values, step(disturbed, k, t, 0.2, f).at("d").values);
  }
  Fields out;
  other.fails_at = other.calls + 3;
  ASSERT_TRUE(disturbed.begin_step({3, 1, 0.4, 0.2}).ok());
  EXPECT_FALSE(disturbed.iterate(force_of(1), out).ok());
  ASSERT_TRUE(disturbed.rollback().ok());
  ASSERT_TRUE(disturbed.checkpoint(folder).ok());
  ASSERT_TRUE(resumed.restore(folder).ok());
  for (int k = 0; k < 2; ++k) {
    const double t = 0.4 + 0.1 * k;
    const auto number = static_cast<std::uint64_t>(k) + 3;
    const auto expected = step(smooth, number, t, 0.1, f).at("d").values;
    EXPECT_EQ(step(disturbed, number, t, 0.1, f, 2).at("d").values, expected);
    EXPECT_EQ(step(resumed, number, t, 0.1, f).at("d").values, expected);
  }
  std::filesystem::remove_all(folder);
}

} // namespace
} // namespace drogue::participant
