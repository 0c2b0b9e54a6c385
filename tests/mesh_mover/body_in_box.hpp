// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "common/mesh/msh.hpp"
#include "mesh_mover/standalone.hpp"
#include "tests/mesh_mover/box_mesh.hpp"

namespace drogue::test {

/// A folder of its own with box.msh, a small body in the middle of a graded box; the config goes beside it.
class BodyInBox : public testing::Test {
 protected:
  /// @param growth of the cells from the body outward
  explicit BodyInBox(double growth) : growth_(growth) {}

  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / fmt::format("drogue_body_in_box_{}", getpid());
    std::filesystem::create_directories(folder_);
    const auto axis = graded(1, 5, growth_);
    auto mesh = box_mesh({axis, axis, axis}, [](int i, int j, int k) {
      const auto inside = [](int a) { return a == 4 || a == 5; };
      return inside(i) && inside(j) && inside(k);
    });
    auto& material = mesh.node_fields["material"];
    material.components = 3;
    for (const double x : mesh.points) material.values.push_back(10 * x);
    ASSERT_TRUE(mesh::write_msh(folder_ / "box.msh", mesh).ok());
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] Result<mesh_mover::Case> load_config(const std::string& text, Role role) const {
    std::ofstream(folder_ / "mesh.textproto") << text;
    return mesh_mover::load_case(folder_ / "mesh.textproto", role);
  }
  /// Of a config without errors, its results in the folder.
  [[nodiscard]] mesh_mover::Case valid_case(const std::string& text, Role role = Role::alone) const {
    auto input = load_config(text, role);
    EXPECT_TRUE(input.ok()) << input.error().message;
    input->settings.output.directory = folder_ / "results";
    return std::move(*input);
  }

  std::filesystem::path folder_;

 private:
  double growth_;
};

} // namespace drogue::test
