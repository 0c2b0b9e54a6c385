// SPDX-License-Identifier: GPL-3.0-or-later
//
// The balance of forces on a coarse T-10 (half the elements of the paper's along every edge), both kinds of
// elements.
#include <gtest/gtest.h>

#include "tests/support/verify.hpp"
#include "tests/verification/t10_balance.hpp"

namespace drogue::structure {
namespace {

void check(bool triangles) {
  const parachute::Subdivision rows{
      .main_rows = 6, .skirt_rows = 1, .across_vent = 1, .across_seam = 1, .across_skirt = 1};
  config::Report report;
  Case c;
  c.settings = drogue::test::t10_settings(1, 2.5e-3);
  auto model = build_model(c.settings, drogue::test::t10_mesh(!triangles, rows, 1), report);
  ASSERT_TRUE(model) << report.lines().front();
  c.model = std::make_unique<const Model>(std::move(*model));
  c.start = rest_state(*c.model);
  const State state = test::polish(c, test::inflate(c));
  drogue::test::verify_relative(triangles ? "t10/coarse_t3" : "t10/coarse_q9", "vertical_line_force",
                                test::vertical_line_force(*c.model, state),
                                0.5 * test::projected_area(*c.model, state), 1e-6);
}

TEST(T10, VerticalForcesBalanceOnQuadrilaterals) {
  check(false);
}
TEST(T10, VerticalForcesBalanceOnTriangles) {
  check(true);
}

} // namespace
} // namespace drogue::structure
