// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/program.hpp"

#include "fluid_solver/fluid_participant.hpp"
#include "fluid_solver/standalone.hpp"

namespace drogue::fluid {

Result<void> check(const std::filesystem::path& file, Role role) {
  const auto input = load_case(file, role);
  if (!input) return input.error();
  fmt::print("{}: ok\n", file.string());
  return {};
}

Result<void> run(const std::filesystem::path& file, const std::string& endpoint) {
  auto input = load_case(file, endpoint.empty() ? Role::alone : Role::participant);
  if (!input) return input.error();
  if (!endpoint.empty()) return serve_flow(**input, endpoint);
  std::error_code ignored;
  return run_standalone(**input, std::filesystem::read_symlink("/proc/self/exe", ignored));
}

} // namespace drogue::fluid
