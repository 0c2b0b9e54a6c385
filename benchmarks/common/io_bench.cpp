// SPDX-License-Identifier: GPL-3.0-or-later
//
// Reading and writing a mesh of the size of the quick T-10 case: a cube of n^3 cells, five tetrahedra each.
#include <benchmark/benchmark.h>

#include <cmath>

#include "common/io/state_file.hpp"
#include "common/io/vtu.hpp"
#include "common/mesh/msh.hpp"

namespace drogue {
namespace {

mesh::Mesh cube(std::int32_t n) {
  mesh::Mesh mesh;
  const std::int32_t m = n + 1;
  for (std::int32_t i = 0; i < m * m * m; ++i)
    mesh.points.insert(mesh.points.end(), {std::sin(i % m), std::cos(i / m % m), std::sqrt(i / (m * m))});
  mesh::ElementBlock block{"fluid", mesh::ElementKind::tet4, {}};
  constexpr int corners[5][4] = {{0, 1, 2, 4}, {3, 1, 2, 7}, {5, 1, 4, 7}, {6, 2, 4, 7}, {1, 2, 4, 7}};
  for (std::int32_t k = 0; k < n; ++k)
    for (std::int32_t j = 0; j < n; ++j)
      for (std::int32_t i = 0; i < n; ++i)
        for (const auto& tet : corners)
          for (const int c : tet)
            block.nodes.push_back((k + c / 4) * m * m + (j + c / 2 % 2) * m + i + c % 2);
  mesh.blocks.push_back(block);
  return mesh;
}

std::filesystem::path file(const char* name) {
  return std::filesystem::temp_directory_path() / name;
}

void write_vtu(benchmark::State& state) {
  const mesh::Mesh mesh = cube(20);
  const io::VtuData data{mesh.points, {&mesh.blocks[0]}, {{"velocity", 3, mesh.points}}, {}};
  for (auto _ : state)
    if (!io::write_vtu(file("drogue_bench.vtu"), data)) state.SkipWithError("cannot write");
}
BENCHMARK(write_vtu)->Unit(benchmark::kMillisecond);

void write_msh(benchmark::State& state) {
  const mesh::Mesh mesh = cube(20);
  for (auto _ : state)
    if (!mesh::write_msh(file("drogue_bench.msh"), mesh)) state.SkipWithError("cannot write");
}
BENCHMARK(write_msh)->Unit(benchmark::kMillisecond);

void read_msh(benchmark::State& state) {
  if (!mesh::write_msh(file("drogue_bench.msh"), cube(20))) state.SkipWithError("cannot write");
  for (auto _ : state)
    if (!mesh::read_msh(file("drogue_bench.msh"))) state.SkipWithError("cannot read");
}
BENCHMARK(read_msh)->Unit(benchmark::kMillisecond);

void read_state(benchmark::State& state) {
  io::State content{"bench", "", 0, 0, {}};
  content.add("velocity", {100000, 3}, std::vector<double>(300000, 0.1));
  if (!io::write_state(file("drogue_bench.state"), content)) state.SkipWithError("cannot write");
  for (auto _ : state)
    if (!io::read_state(file("drogue_bench.state"))) state.SkipWithError("cannot read");
}
BENCHMARK(read_state)->Unit(benchmark::kMillisecond);

} // namespace
} // namespace drogue
