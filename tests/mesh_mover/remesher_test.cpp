// SPDX-License-Identifier: GPL-3.0-or-later
// A body that is carried through a box further than its mesh can follow: the mesh is replaced, the boundary
// goes on as if nothing had happened.
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "common/mesh/msh.hpp"
#include "mesh_mover/mesh_participant.hpp"
#include "mesh_mover/standalone.hpp"
#include "tests/mesh_mover/body_in_box.hpp"
#include "tests/mesh_mover/mover_cases.hpp"
#include "tests/mesh_mover/plane_mesh.hpp"

namespace drogue::mesh_mover {
namespace {

namespace fs = std::filesystem;

constexpr const char* config_text = R"config(mesh: "box.msh"
boundary { name: "body" displacement { x: "0.25*t" y: "0.05*sin(t)" } }
boundary { name: "x0" fixed {} }
boundary { name: "x1" fixed {} }
boundary { name: "y0" sliding { normal: "y" } }
boundary { name: "y1" sliding { normal: "y" } }
boundary { name: "z0" translated {} }
boundary { name: "z1" translated {} }
interface: "body"
step: 0.25
steps: 12
remesh { mean_ratio: 0.25 }
output { field_interval: 0 }
)config";

class Remeshing : public test::BodyInBox {
 protected:
  Remeshing() : BodyInBox(1.4) {}

  Case load(const std::string& text = config_text, Role role = Role::alone) { return valid_case(text, role); }
  std::vector<fs::path> new_meshes(const fs::path& folder) {
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.path().filename().string().rfind("remesh_", 0) == 0) found.push_back(entry.path());
    std::sort(found.begin(), found.end());
    return found;
  }
};

TEST_F(Remeshing, CarriesABodyOnWithANewMesh) {
  const auto done = run_standalone(load());
  ASSERT_TRUE(done.ok()) << done.error().message;
  const auto meshes = new_meshes(folder_ / "results");
  ASSERT_GE(meshes.size(), 1u);
  const auto mesh = mesh::read_msh(meshes.back());
  ASSERT_TRUE(mesh.ok());
  const int step = std::stoi(meshes.back().stem().string().substr(7));
  // Boundary nodes carry how far they have come, exactly; the body's are at their starts plus its motion.
  const auto& moved = mesh->node_fields.at(start_displacement_name).values;
  for (const std::int32_t node : mesh->nodes_of("body")) {
    EXPECT_NEAR(moved[3 * static_cast<std::size_t>(node)], 0.25 * 0.25 * step, 1e-12);
    EXPECT_NEAR(moved[3 * static_cast<std::size_t>(node) + 1], 0.05 * std::sin(0.25 * step), 1e-12);
  }
}

/// The participant, driven by hand.
class Peer {
 public:
  Peer(Case input, const fs::path& folder) : solver(std::move(input)) {
    fs::create_directories(folder);
    EXPECT_TRUE(solver.configure({folder, 0, 0.1, false}).ok());
    auto mesh = solver.initialize();
    EXPECT_TRUE(mesh.ok());
    interface = std::move(*mesh);
  }
  std::vector<double> step(int k) {
    EXPECT_TRUE(solver.begin_step({static_cast<std::uint64_t>(k), 1, 0.1 * (k - 1), 0.1}).ok());
    participant::Fields inputs, outputs;
    participant::FloatArray d{{interface.points.size() / 3, 3},
                              std::vector<double>(interface.points.size(), 0.0)};
    for (std::size_t i = 0; i < d.values.size(); i += 3) d.values[i] = 0.0625 * k;
    inputs["displacement"] = d;
    inputs["translation"] = {{1, 3}, {0, 0, 0.001 * k}};
    const auto report = solver.iterate(inputs, outputs);
    EXPECT_TRUE(report.ok()) << report.error().message;
    EXPECT_TRUE(solver.commit(true).ok());
    return outputs["mesh_displacement"].values;
  }
  MeshParticipant solver;
  participant::InterfaceMesh interface;
};

TEST_F(Remeshing, AParticipantOffersAMeshAndGoesOnWithIt) {
  Peer peer(load(config_text, Role::participant), folder_ / "peer");
  EXPECT_TRUE(peer.solver.describe().can_replace_mesh);
  std::optional<participant::NewMesh> offer;
  int k = 0;
  while (!offer && k < 12) {
    (void)peer.step(++k);
    offer = peer.solver.new_mesh();
  }
  ASSERT_TRUE(offer.has_value());
  EXPECT_NE(offer->reason.find("mean ratio"), std::string::npos) << offer->reason;
  const auto replaced = peer.solver.replace_mesh(*offer, false);
  ASSERT_TRUE(replaced.ok()) << replaced.error().message;
  EXPECT_FALSE(peer.solver.new_mesh().has_value());
  const auto mesh = mesh::read_msh(offer->file);
  ASSERT_TRUE(mesh.ok());
  EXPECT_EQ(replaced->mesh_hash, mesh::hash(*mesh));
  ASSERT_EQ(replaced->mesh_nodes.size(), peer.interface.mesh_nodes.size());
  // Displacements of the interface go on from Initialize, those of the mesh from the new file.
  fs::create_directories(folder_ / "kept");
  ASSERT_TRUE(peer.solver.checkpoint(folder_ / "kept").ok());
  const std::vector<double> u = peer.step(k + 1);
  ASSERT_EQ(u.size(), mesh->points.size());
  for (std::size_t n = 0; n < replaced->mesh_nodes.size(); ++n) {
    const auto node = static_cast<std::size_t>(replaced->mesh_nodes[n]);
    EXPECT_NEAR(mesh->points[3 * node] + u[3 * node], peer.interface.points[3 * n] + 0.0625 * (k + 1), 1e-12);
    EXPECT_NEAR(mesh->points[3 * node + 1] + u[3 * node + 1], peer.interface.points[3 * n + 1], 1e-12);
    EXPECT_NEAR(mesh->node_fields.at("material").values[3 * node], 10 * peer.interface.points[3 * n], 1e-12);
  }
  for (const std::int32_t node : mesh->nodes_of("z1")) {
    const auto i = 3 * static_cast<std::size_t>(node);
    const bool is_fixed = std::abs(mesh->points[i]) == 1; // on x0 or x1
    EXPECT_NEAR(mesh->points[i + 2] + u[i + 2], is_fixed ? 1 : 1 + 0.001 * (k + 1), 1e-12);
  }
  // Another process that takes the mesh before its state goes on to the bit.
  Peer other(load(config_text, Role::participant), folder_ / "other");
  EXPECT_FALSE(other.solver.restore(folder_ / "kept").ok()); // not on the first mesh
  ASSERT_TRUE(other.solver.replace_mesh(*offer, true).ok());
  ASSERT_TRUE(other.solver.restore(folder_ / "kept").ok());
  const std::vector<double> again = other.step(k + 1);
  ASSERT_EQ(again.size(), u.size());
  EXPECT_EQ(std::memcmp(again.data(), u.data(), 8 * u.size()), 0);
}

TEST_F(Remeshing, AnotherMeshThanTheOneNamedIsRefused) {
  Peer peer(load(config_text, Role::participant), folder_ / "peer");
  const auto replaced = peer.solver.replace_mesh({folder_ / "box.msh", "0123", ""}, false);
  ASSERT_FALSE(replaced.ok());
  EXPECT_EQ(replaced.error().kind, ErrorKind::config);
}

/// The program makes the mesh in a process of its own: the same one every time, as runs that repeat need it.
TEST_F(Remeshing, TheProgramMakesTheSameMeshEveryTime) {
  (void)load();
  const auto run = [&](const char* folder) {
    fs::create_directories(folder_ / folder);
    return std::system(fmt::format("cd {0} && {1}/mesh_mover run {2}/mesh.textproto > log 2>&1",
                                   (folder_ / folder).string(), DROGUE_BIN_DIR, folder_.string())
                           .c_str());
  };
  ASSERT_EQ(run("first"), 0);
  ASSERT_EQ(run("a_second_one_with_a_longer_name"), 0);
  const auto a = new_meshes(folder_ / "first/results"),
             b = new_meshes(folder_ / "a_second_one_with_a_longer_name/results");
  ASSERT_GE(a.size(), 1u);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    EXPECT_EQ(mesh::hash(*mesh::read_msh(a[i])), mesh::hash(*mesh::read_msh(b[i])));
}

/// A small square in the plane, carried three times its own size to the side.
TEST_F(Remeshing, CarriesABodyInThePlaneOnWithANewMesh) {
  const auto axis = test::graded(1, 6, 1.6);
  const auto inside = [](int a) { return a >= 5 && a <= 6; };
  const mesh::Mesh plane = test::plane_mesh(axis, axis, [&](int i, int j) { return inside(i) && inside(j); });
  ASSERT_TRUE(mesh::write_msh(folder_ / "plane.msh", plane).ok());
  Case input = valid_case(R"config(mesh: "plane.msh"
boundary { name: "body" displacement { x: "0.1*t" y: "0.05*sin(t)" } }
boundary { name: "x0" fixed {} }
boundary { name: "x1" fixed {} }
boundary { name: "y0" sliding { normal: "y" } }
boundary { name: "y1" sliding { normal: "y" } }
interface: "body"
tolerance: 1e-8
step: 0.5
steps: 16
remesh { mean_ratio: 0.3 }
stop { mean_ratio: 0.18 }
)config");
  const auto done = run_standalone(input);
  ASSERT_TRUE(done.ok()) << done.error().message;
  const auto meshes = new_meshes(folder_ / "results");
  ASSERT_GE(meshes.size(), 1u);
  const auto mesh = mesh::read_msh(meshes.back());
  ASSERT_TRUE(mesh.ok());
  const int step = std::stoi(meshes.back().stem().string().substr(7));
  const auto& moved = mesh->node_fields.at(start_displacement_name).values;
  for (const std::int32_t node : mesh->nodes_of("body")) {
    EXPECT_NEAR(moved[3 * static_cast<std::size_t>(node)], 0.1 * 0.5 * step, 1e-12);
    EXPECT_NEAR(moved[3 * static_cast<std::size_t>(node) + 1], 0.05 * std::sin(0.5 * step), 1e-12);
  }
  // Without new meshes it stops on the way.
  input.settings.remesh.reset();
  EXPECT_FALSE(run_standalone(input).ok());
}

} // namespace
} // namespace drogue::mesh_mover
