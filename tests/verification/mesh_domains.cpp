// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/verification/mesh_domains.hpp"

#include <filesystem>

#include <gmsh.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "common/mesh/gmsh_session.hpp"
#include "common/mesh/msh.hpp"

namespace drogue::test {
namespace {

namespace fs = std::filesystem;
namespace geo = gmsh::model::geo;

void name_group(int dimension, const std::vector<int>& tags, const std::string& name) {
  gmsh::model::setPhysicalName(dimension, gmsh::model::addPhysicalGroup(dimension, tags), name);
}

template <class Build>
mesh::Mesh mesh_of(int dimension, Build build) {
  const fs::path file = fs::temp_directory_path() / fmt::format("drogue_domain_{}.msh", getpid());
  {
    const mesh::GmshSession session;
    gmsh::option::setNumber("General.NumThreads", 1);
    gmsh::option::setNumber("Mesh.MeshSizeExtendFromBoundary", 1);
    gmsh::option::setNumber("Mesh.MeshSizeFromPoints", 1);
    gmsh::option::setNumber("Mesh.Algorithm3D", 1);
    build();
    gmsh::model::mesh::generate(dimension);
    gmsh::write(file);
  }
  auto result = mesh::read_msh(file);
  fs::remove(file);
  EXPECT_TRUE(result.ok()) << result.error().message;
  return std::move(*result);
}

void build_plate() {
  const double height = 0.01;
  const auto point = [](double x, double y, double size) { return geo::addPoint(x, y, 0, size); };
  const int plate[2] = {point(-0.5, 0, 0.01), point(0.5, 0, 0.01)};
  const int above[2] = {point(-0.5, height, 0.02), point(0.5, height, 0.02)};
  const int below[2] = {point(-0.5, -height, 0.02), point(0.5, -height, 0.02)};
  const int lines[3] = {geo::addLine(plate[0], plate[1]), geo::addLine(above[0], above[1]),
                        geo::addLine(below[0], below[1])};
  const int up[2] = {geo::addLine(plate[0], above[0]), geo::addLine(plate[1], above[1])};
  const int down[2] = {geo::addLine(plate[0], below[0]), geo::addLine(plate[1], below[1])};
  const int corners[4] = {point(-1, -1, 0.15), point(1, -1, 0.15), point(1, 1, 0.15), point(-1, 1, 0.15)};
  std::vector<int> outer;
  for (int k = 0; k < 4; ++k) outer.push_back(geo::addLine(corners[k], corners[(k + 1) % 4]));
  const int upper = geo::addPlaneSurface({geo::addCurveLoop({lines[0], up[1], -lines[1], -up[0]})});
  const int lower = geo::addPlaneSurface({geo::addCurveLoop({lines[2], -down[1], -lines[0], down[0]})});
  const int rim = geo::addCurveLoop({-down[0], up[0], lines[1], -up[1], down[1], -lines[2]});
  const int rest = geo::addPlaneSurface({geo::addCurveLoop(outer), rim});
  for (const int line : lines) geo::mesh::setTransfiniteCurve(line, 51);
  for (const int line : {up[0], up[1], down[0], down[1]}) geo::mesh::setTransfiniteCurve(line, 2);
  for (const int surface : {upper, lower}) geo::mesh::setTransfiniteSurface(surface, "Alternate");
  geo::synchronize();
  name_group(1, {lines[0]}, "plate");
  name_group(1, outer, "outer");
  name_group(2, {upper, lower}, "layer");
  name_group(2, {rest}, "fluid");
}

void build_sphere() {
  namespace occ = gmsh::model::occ;
  const int box = occ::addBox(-3, -3, -3, 8, 6, 6);
  const int ball = occ::addSphere(0, 0, 0, 0.5);
  gmsh::vectorpair volume;
  std::vector<gmsh::vectorpair> parents;
  occ::cut({{3, box}}, {{3, ball}}, volume, parents);
  occ::synchronize();
  std::vector<int> sphere, outer;
  gmsh::vectorpair faces;
  gmsh::model::getEntities(faces, 2);
  for (const auto& [dimension, tag] : faces) {
    std::string type;
    gmsh::model::getType(dimension, tag, type);
    (type == "Sphere" ? sphere : outer).push_back(tag);
  }
  gmsh::vectorpair points;
  gmsh::model::getEntities(points, 0);
  gmsh::model::mesh::setSize(points, 0.9);
  gmsh::vectorpair on_sphere;
  gmsh::model::getBoundary({{2, sphere.front()}}, on_sphere, false, false, true);
  gmsh::model::mesh::setSize(on_sphere, 0.12);
  name_group(2, sphere, "sphere");
  name_group(2, outer, "outer");
  name_group(3, {volume.front().second}, "fluid");
}

} // namespace

mesh::Mesh plate_in_square() {
  return mesh_of(2, build_plate);
}

mesh::Mesh sphere_in_box() {
  return mesh_of(3, build_sphere);
}

} // namespace drogue::test
