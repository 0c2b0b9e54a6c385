// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <numbers>

#include "coupler/projection/interface.hpp"

namespace drogue::projection::test {

using mesh::ElementKind;
using Point = std::array<double, 3>;
using PointMap = std::function<Point(double, double)>;

/// A grid of n x n quadrilaterals (each two triangles for T3 and T6) on the unit square, mapped.
/// `other_diagonal` turns the diagonals of the triangles.
Surface grid(ElementKind kind, int n, const PointMap& map, bool other_diagonal = false);
Surface plate(ElementKind kind, int n, bool other_diagonal = false);

/// The upper unit hemisphere: a pole, and m rings of 4 m points, every other ring turned by half a spacing.
Surface lat_long_hemisphere(int m);
/// The upper unit hemisphere: four faces of an octahedron, each split n times.
Surface octahedron_hemisphere(int n);
/// The upper unit hemisphere in Q9: each face of an octahedron in three patches of n x n elements.
Surface quad9_hemisphere(int n);
/// The whole unit sphere (eight octants of the octahedron), normals outwards.
Surface sphere(int n);

/// A chain of n line elements, mapped from [0, 1]; nodes in order along it.
Surface chain(ElementKind kind, int n, const std::function<Point(double)>& map);
/// The interval [0, 1] on the x axis.
Surface interval(ElementKind kind, int n);

/// A flat disc of radius one in Q9 or T3 (four square patches pressed into quadrants, n x n each).
Surface disc(ElementKind kind, int n);
/// Both sides of a disc: T3, nodes doubled inside, single on the rim; the second side turned over, its nodes
/// behind those of the first.
Surface two_sided_disc(int n);
/// {n}: nodes of the first side's node on the second side (the same node on the rim).
std::vector<std::int32_t> other_side(const Surface& two_sided);

Surface combine_surfaces(const Surface& a, const Surface& b);
/// Joins nodes at the same place.
Surface weld(const Surface& surface);
void turn_over(Surface& surface);

/// Values f(point) of 3 components on the reference nodes.
std::vector<double> sample(const Surface& surface, const std::function<Point(const Point&)>& f);
/// (f(x,y,z), f(y,z,x), f(z,x,y)) with f = sin 4x cos 3y + z.
Point wavy(const Point& x);
/// Pairs the two; a failure of the running test when they do not fit.
Interface pair(const Surface& structure, const Surface& fluid, const Settings& settings = {});

/// sqrt(sum |a - b|^2 / sum |b|^2)
double relative_error(const std::vector<double>& a, const std::vector<double>& b);
/// Infinite when the sizes differ.
double largest_difference(const std::vector<double>& a, const std::vector<double>& b);

} // namespace drogue::projection::test
