// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/verification/coupled_run.hpp"

#include <algorithm>

#include "coupler/launcher/process.hpp"

namespace drogue::test {

double CoupledRun::mean_iterations(std::size_t leave_out) const {
  const std::vector<double> n = column(steps, "iterations");
  double sum = 0;
  for (std::size_t i = leave_out; i < n.size(); ++i) sum += n[i];
  return n.size() > leave_out ? sum / static_cast<double>(n.size() - leave_out) : 0;
}

double CoupledRun::most_iterations() const {
  const std::vector<double> n = column(steps, "iterations");
  return n.empty() ? 0 : *std::max_element(n.begin(), n.end());
}

bool ends_well(const std::filesystem::path& folder, std::chrono::minutes longest) {
  auto coupler =
      launcher::Process::start({{std::string(DROGUE_BIN_DIR) + "/coupler", "run", "case.textproto"},
                                {},
                                folder,
                                folder / "output.txt"});
  EXPECT_TRUE(coupler.ok());
  if (!coupler.ok()) return false;
  const auto& exit = coupler->wait(longest);
  return exit.has_value() && exit->clean();
}

CoupledRun run_coupled(const std::filesystem::path& folder, std::chrono::minutes longest) {
  EXPECT_TRUE(ends_well(folder, longest)) << read_text(folder / "output.txt");
  return {read_csv(folder / "run/drag.csv"), read_csv(folder / "run/coupling.csv")};
}

std::vector<double> column(const Table& table, const std::string& name) {
  std::vector<double> values;
  for (std::size_t i = 0; i < table.rows.size(); ++i) values.push_back(table.at(i, name));
  return values;
}

} // namespace drogue::test
