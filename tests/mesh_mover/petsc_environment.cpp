// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "mesh_mover/conjugate_gradient.hpp"

namespace {

/// PETSc for the whole test program.
class PetscEnvironment : public testing::Environment {
 public:
  void SetUp() override {
    auto session = drogue::mesh_mover::PetscSession::start();
    ASSERT_TRUE(session.ok()) << session.error().message;
    session_ = std::move(*session);
  }
  void TearDown() override { session_.reset(); }

 private:
  std::unique_ptr<drogue::mesh_mover::PetscSession> session_;
};

[[maybe_unused]] const auto* const environment = testing::AddGlobalTestEnvironment(new PetscEnvironment);

} // namespace
