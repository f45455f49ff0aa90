// Walls of known shape.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "../fixture.hpp"
#include "contact/wall_surface.hpp"

namespace glossa::test {

/// place(u, v) over a grid of nu x nv cells, 0 <= u, v <= 1; normals along du x dv.
template <class Place>
WallSurface patch(int nu, int nv, Place&& place) {
  WallSurface wall;
  for (int i = 0; i <= nu; ++i)
    for (int j = 0; j <= nv; ++j) wall.vertices.push_back(place(double(i) / nu, double(j) / nv));
  const auto vertex = [&](int i, int j) { return Index(i * (nv + 1) + j); };
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nv; ++j) {
      wall.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      wall.triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
    }
  return wall;
}

/// A square of 40 mm in z = 0, normal upwards, its corner at the origin turned and moved off the lattice if asked for.
inline WallSurface square(int cells, const Matrix3& turn = Matrix3::Identity()) {
  return patch(cells, cells,
               [&](double u, double v) -> Vector3 { return turn * Vector3(0.04 * (u - 0.5), 0.04 * (v - 0.5), 0.0); });
}

/// Closed, normals outwards: latitudes and longitudes, the poles as degenerate rows left out of the triangles.
inline WallSurface sphere(double radius, int cells) {
  WallSurface wall = patch(2 * cells, cells, [&](double u, double v) -> Vector3 {
    const double along = 2.0 * std::numbers::pi * u, down = std::numbers::pi * (1.0 - v);
    return radius * Vector3(std::sin(down) * std::cos(along), std::sin(down) * std::sin(along), std::cos(down));
  });
  std::erase_if(wall.triangles, [&](const Triangle& t) {
    const auto at = [&](std::size_t k) { return wall.vertices[static_cast<std::size_t>(t[k])]; };
    return (at(0) - at(1)).norm() < 1e-9 || (at(1) - at(2)).norm() < 1e-9 || (at(2) - at(0)).norm() < 1e-9;
  });
  return wall;
}

/// Closed box from -size / 2 to size / 2, normals outwards.
inline WallSurface box(const Vector3& size) {
  WallSurface wall;
  for (int k = 0; k < 8; ++k)
    wall.vertices.push_back(0.5 * size.cwiseProduct(Vector3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1)));
  const std::array<std::array<Index, 4>, 6> faces{
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& f : faces) {
    wall.triangles.push_back({f[0], f[1], f[2]});
    wall.triangles.push_back({f[0], f[2], f[3]});
  }
  return wall;
}

inline WallSurface reversed(WallSurface wall) {
  for (Triangle& t : wall.triangles) std::swap(t[1], t[2]);
  return wall;
}

/// The same wall, vertices and triangles in another order, triangles starting at another corner.
inline WallSurface shuffled(const WallSurface& wall, std::uint64_t seed) {
  Random random(seed);
  const auto permutation = [&](std::size_t count) {
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t k = count; k > 1; --k)
      std::swap(order[k - 1], order[static_cast<std::size_t>(random(0.0, double(k)))]);
    return order;
  };
  WallSurface result;
  std::vector<Index> place(wall.vertices.size());
  for (const std::size_t v : permutation(wall.vertices.size())) {
    place[v] = Index(result.vertices.size());
    result.vertices.push_back(wall.vertices[v]);
  }
  for (const std::size_t t : permutation(wall.triangles.size())) {
    Triangle triangle = wall.triangles[t];
    for (Index& v : triangle) v = place[static_cast<std::size_t>(v)];
    std::rotate(triangle.begin(), triangle.begin() + static_cast<int>(random(0.0, 3.0)), triangle.end());
    result.triangles.push_back(triangle);
  }
  return result;
}

}  // namespace glossa::test
