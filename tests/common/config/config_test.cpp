// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/config/config.hpp"

#include <cmath>
#include <fstream>

#include <gtest/gtest.h>

#include "common/config/expression.hpp"
#include "drogue/v1/coupler.pb.h"
#include "drogue/v1/structure.pb.h"

namespace drogue::config {
namespace {

/// Writes `text` to a file of its own in the test's folder and loads it.
template <class Proto>
std::vector<std::string> errors_of(const std::string& text, Source* source = nullptr) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "config_test";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "mesh.msh") << "x";
  const auto file = folder / "case.textproto";
  std::ofstream(file) << text;
  Proto message;
  Report report;
  const Source s = load(file, message, report);
  if (source) *source = s;
  std::vector<std::string> lines = report.lines();
  for (std::string& line : lines) line.erase(0, line.find("case.textproto"));
  return lines;
}

TEST(Load, AcceptsAGoodConfig) {
  Source source;
  EXPECT_TRUE(errors_of<v1::StructureConfig>("mesh: 'mesh.msh'\ntime { step: 0.1 }\n", &source).empty());
  EXPECT_NE(source.where("time.step").find(":2:8"), std::string::npos) << source.where("time.step");
}

TEST(Load, ReportsEveryUnknownFieldWithPositionAndNearestName) {
  const auto lines = errors_of<v1::StructureConfig>("mesh: 'mesh.msh'\n"
                                                    "membrain { group: 'c' }\n"
                                                    "time { stepp: 1 }\n");
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0], "case.textproto:2:1: error: unknown field \"membrain\"; did you mean \"membrane\"?");
  EXPECT_EQ(lines[1], "case.textproto:3:8: error: unknown field \"stepp\"; did you mean \"step\"?");
}

TEST(Load, ReportsRangesRequirementsFilesAndExpressionsAtOnce) {
  const auto lines = errors_of<v1::StructureConfig>("mesh: 'missing.msh'\n"
                                                    "time { rho_infinity: 1.5 step: -1 }\n"
                                                    "pressure { group: 'c' value: '2*tt' }\n"
                                                    "membrane { group: 'c' thickness: 1 density: 1 }\n");
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_NE(lines[0].find("1:1: error: mesh names a file that does not exist"), std::string::npos)
      << lines[0];
  EXPECT_NE(lines[1].find("4:1: error: membrane[0].youngs_modulus is missing (stress [Pa])"),
            std::string::npos)
      << lines[1];
  EXPECT_NE(lines[2].find("3:23: error: pressure[0].value: the expression \"2*tt\""), std::string::npos)
      << lines[2];
  EXPECT_NE(lines[3].find("2:26: error: time.step is -1; it must be above 0 (time [s])"), std::string::npos)
      << lines[3];
  EXPECT_NE(lines[4].find("2:8: error: time.rho_infinity is 1.5; it must be in [0, 1]"), std::string::npos)
      << lines[4];
}

TEST(Load, NamesTheValidValuesOfAnEnumeration) {
  const auto lines = errors_of<v1::CaseConfig>("acceleration { method: IQN_ISL }\n");
  ASSERT_GE(lines.size(), 1u);
  EXPECT_NE(lines[0].find(
                "\"IQN_ISL\" is not a value of method; did you mean \"IQN_ILS\"? (valid: CONSTANT, AITKEN"),
            std::string::npos)
      << lines[0];
}

TEST(Load, RefusesValuesThatAreNotFinite) {
  const auto lines = errors_of<v1::StructureConfig>("mesh: 'mesh.msh'\ntime { step: nan }\n");
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find("time.step is nan; it must be finite"), std::string::npos) << lines[0];
}

TEST(Load, SaysWhenTheFileIsMissing) {
  v1::CaseConfig message;
  Report report;
  (void)load("no/such/file.textproto", message, report);
  ASSERT_EQ(report.lines().size(), 1u);
  EXPECT_EQ(report.lines()[0].rfind("no/such/file.textproto: error: cannot be opened", 0), 0u);
}

TEST(UnknownName, GivesNearestAndAll) {
  Report report;
  const std::vector<std::string> valid{"inflow", "outflow"};
  report_unknown_name(report, "f:1:2", "boundary", "inflw", "box.msh", valid);
  EXPECT_EQ(report.lines()[0], "f:1:2: error: there is no boundary named \"inflw\" in box.msh; did you mean "
                               "\"inflow\"? (there are: inflow, outflow)");
}

TEST(Expression, EvaluatesAndCopiesIndependently) {
  const auto parsed = Expression::parse("x + 2*y + 3*z + min(1, t/0.1) + pi");
  ASSERT_TRUE(parsed.ok());
  const Expression copy = *parsed;
  EXPECT_DOUBLE_EQ((*parsed)(1, 2, 3, 0.05), 14.5 + std::acos(-1.0));
  EXPECT_DOUBLE_EQ(copy(0, 0, 0, 1), 1 + std::acos(-1.0));
  EXPECT_FALSE(copy.is_zero());
  EXPECT_TRUE(Expression().is_zero());
  EXPECT_TRUE(Expression::parse("0.0")->is_zero());
}

} // namespace
} // namespace drogue::config
