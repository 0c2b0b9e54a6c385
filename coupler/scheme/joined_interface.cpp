// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/scheme/joined_interface.hpp"

#include <algorithm>

namespace drogue::coupler {

using participant::FloatArray;
using participant::InterfaceMesh;

namespace {

const std::vector<double>& reference_of(const InterfaceMesh& mesh) {
  return mesh.reference.empty() ? mesh.points : mesh.reference;
}
const std::vector<double>& material_of(const InterfaceMesh& mesh) {
  return mesh.material.empty() ? reference_of(mesh) : mesh.material;
}

void append(std::vector<double>& to, const std::vector<double>& values) {
  to.insert(to.end(), values.begin(), values.end());
}

} // namespace

InterfaceMesh joined(std::span<const InterfaceMesh> meshes) {
  const auto any = [&](std::vector<double> InterfaceMesh::*values) {
    return std::any_of(meshes.begin(), meshes.end(),
                       [&](const auto& mesh) { return !(mesh.*values).empty(); });
  };
  const bool reference = any(&InterfaceMesh::reference), material = any(&InterfaceMesh::material),
             velocity = any(&InterfaceMesh::velocity);
  InterfaceMesh all;
  for (const InterfaceMesh& mesh : meshes) {
    const auto first = static_cast<std::int64_t>(all.points.size() / 3);
    for (const auto& array : participant::element_arrays)
      for (const std::int64_t node : mesh.*array.elements) (all.*array.elements).push_back(first + node);
    append(all.points, mesh.points);
    if (reference) append(all.reference, reference_of(mesh));
    if (material) append(all.material, material_of(mesh));
    if (velocity) append(all.velocity, mesh.velocity);
    if (velocity) all.velocity.resize(all.points.size(), 0.0);
  }
  return all;
}

FloatArray rows_of(const FloatArray& array, std::size_t first, std::size_t count) {
  const std::size_t row = array.shape[1];
  const auto start = array.values.begin() + static_cast<std::ptrdiff_t>(first * row);
  return {{count, row}, {start, start + static_cast<std::ptrdiff_t>(count * row)}};
}

void append_rows(FloatArray& array, const FloatArray& more) {
  array.shape = {(array.shape.empty() ? 0 : array.shape[0]) + more.shape[0], more.shape[1]};
  append(array.values, more.values);
}

} // namespace drogue::coupler
