// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include <fmt/format.h>

namespace drogue::test {

/// Compares a result with its reference: prints the line that scripts/verify collects,
/// `VERIFY case quantity ours reference tolerance pass|FAIL`, and makes the test fail when the two differ by
/// more than `tolerance` (absolute, in the unit of the quantity; NaN fails). Tests that call it carry the
/// label verification.
///
/// @param name      the case, without blanks, e.g. "fluid/taylor_green"
/// @param quantity  what is compared, without blanks, e.g. "velocity_order"
inline void verify(const std::string& name, const std::string& quantity, double ours, double reference,
                   double tolerance) {
  EXPECT_EQ((name + quantity).find_first_of(" \t\n"), std::string::npos) << "no blanks in names: " << name;
  const bool pass = std::abs(ours - reference) <= tolerance;
  fmt::print("VERIFY {} {} {:.8g} {:.8g} {:.3g} {}\n", name, quantity, ours, reference, tolerance,
             pass ? "pass" : "FAIL");
  std::fflush(stdout);
  EXPECT_TRUE(pass) << name << " " << quantity << ": " << ours << " instead of " << reference << " +- "
                    << tolerance;
}

/// As verify, with a tolerance relative to the reference. @pre reference != 0
inline void verify_relative(const std::string& name, const std::string& quantity, double ours,
                            double reference, double relative_tolerance) {
  verify(name, quantity, ours, reference, relative_tolerance * std::abs(reference));
}

/// As verify, for a reference that is an interval: prints its centre and half its width.
inline void verify_between(const std::string& name, const std::string& quantity, double ours, double lower,
                           double upper) {
  verify(name, quantity, ours, 0.5 * (lower + upper), 0.5 * (upper - lower));
}

} // namespace drogue::test
