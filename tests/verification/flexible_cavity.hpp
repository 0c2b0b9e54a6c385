// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

/// The lid-driven cavity with a flexible bottom of Wall (1999) and Mok (2001), as fully defined by Valdes
/// (2007): a unit square, lid and linear inflow at 0.875 < y < 1 with 1 - cos(2 pi t/5), p = 0 on the other
/// side there, a membrane h = 0.002, E = 250, rho_s = 500 below, rho = 1, nu = 0.01. Vertical displacement of
/// its middle, of period 5.
namespace drogue::test {

struct Cavity {
  int cells = 32;
  double time_step = 0.1;
  double end = 60;
  std::string acceleration = "relaxation: 0.5 reuse_steps: 5 filter: 0.1";
  /// Of the case: which program is the structure.
  std::string structure = "command: 'structure_solver' config: 'structure.textproto'";
};

/// All files of the case; its run directory is "run".
void write_case(const std::filesystem::path& folder, const Cavity& c);

} // namespace drogue::test
