// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "surfaces.hpp"

namespace drogue::projection::test {

Interface pair(const Surface& structure, const Surface& fluid, const Settings& settings) {
  auto made = make_interface(structure, fluid, settings);
  if (!made) ADD_FAILURE() << made.error().message;
  return std::move(made).value();
}

} // namespace drogue::projection::test
