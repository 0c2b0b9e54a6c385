// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

/// Helpers of the tests that run the coupler with the participants of oscillator_participant.cpp.
namespace drogue::test {

struct OscillatorCase {
  std::string structure_arguments = {}, fluid_arguments = {}, mesh_mover_arguments = {};
  int steps = 5;
  double time_step = 0.02;
  std::string extra = {}; ///< further fields of the case, e.g. "loop { ... }"
};

inline std::string participant_text(const std::string& role, const std::string& arguments) {
  std::string text = fmt::format("{} {{ command: '{}/oscillator_participant' argument: '{}'", role,
                                 DROGUE_TEST_BIN_DIR, role);
  std::istringstream words(arguments);
  for (std::string word; words >> word;) text += fmt::format(" argument: '{}'", word);
  return text + " }\n";
}

/// An empty folder of this test's own.
inline std::filesystem::path fresh_folder(const std::string& name) {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  const auto folder = std::filesystem::path(testing::TempDir()) / "drogue" /
                      fmt::format("{}.{}.{}", info->test_suite_name(), info->name(), name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

/// Writes the case into `folder`; it runs in folder/run.
inline std::filesystem::path write_case(const std::filesystem::path& folder, const OscillatorCase& c) {
  const auto file = folder / "case.textproto";
  std::ofstream(file) << "name: 'oscillator' run_directory: '" << (folder / "run").string() << "'\n"
                      << participant_text("structure", c.structure_arguments)
                      << participant_text("fluid", c.fluid_arguments)
                      << participant_text("mesh_mover", c.mesh_mover_arguments)
                      << fmt::format("time {{ step: {} steps: {} }}\n", c.time_step, c.steps) << c.extra
                      << "\n";
  return file;
}

/// Reads a .csv file with a header line: rows of numbers, and the index of a column by name.
struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;
  [[nodiscard]] double at(std::size_t row, const std::string& column) const {
    for (std::size_t i = 0; i < columns.size(); ++i)
      if (columns[i] == column) return rows.at(row).at(i);
    ADD_FAILURE() << "no column " << column;
    return 0;
  }
};
inline Table read_csv(const std::filesystem::path& file) {
  Table table;
  std::ifstream stream(file);
  std::string line, cell;
  std::getline(stream, line);
  for (std::istringstream cells(line); std::getline(cells, cell, ',');) table.columns.push_back(cell);
  while (std::getline(stream, line)) {
    table.rows.emplace_back();
    for (std::istringstream cells(line); std::getline(cells, cell, ',');)
      table.rows.back().push_back(std::stod(cell));
  }
  return table;
}

inline std::string read_text(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

} // namespace drogue::test
