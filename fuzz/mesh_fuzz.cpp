// SPDX-License-Identifier: GPL-3.0-or-later
// Mesh files. What is read holds together: every node of an element is there.
#include <cstdlib>

#include "common/mesh/msh.hpp"
#include "fuzz/scratch_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace drogue;
  const auto mesh = mesh::read_msh(fuzz::put("mesh.msh", data, size));
  if (!mesh) return 0;
  for (const mesh::ElementBlock& block : mesh->blocks)
    for (const std::int32_t node : block.nodes)
      if (node < 0 || node >= static_cast<std::int32_t>(mesh->node_count())) std::abort();
  return 0;
}
