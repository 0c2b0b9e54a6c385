// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "common/la_krylov/session.hpp"

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  const auto session = drogue::la::Session::start();
  return session ? RUN_ALL_TESTS() : 1;
}
