// Bodies that touch walls of known shape.
#pragma once

#include "../contact/walls.hpp"
#include "effect/wall_contact.hpp"

namespace glossa::test {

using Wall = std::shared_ptr<const DistanceField>;

/// A distance field around `centre`, 2 mm apart, of a wall given around the origin.
inline Wall field_at(WallSurface wall, const Vector3& centre, double half = 0.03, double spacing = 2e-3) {
  for (Vector3& v : wall.vertices) v += centre;
  DistanceFieldOptions options;
  options.spacing = spacing;
  options.band = 10e-3;
  options.low = centre - Vector3::Constant(half);
  options.high = centre + Vector3::Constant(half);
  return std::make_shared<const DistanceField>(wall, options);
}

/// A square of 120 mm around (0, 0, height), facing down: a roof for a block.
inline Wall roof(double height, double half = 0.045) {
  const WallSurface plane = patch(1, 1, [](double u, double v) -> Vector3 {
    return {0.12 * (u - 0.5), 0.12 * (0.5 - v), 0.0};
  });
  return field_at(plane, Vector3(0.015, 0.015, height), half);
}

/// Points on the top of block(nx, ny, nz): side x side in every face, of wall 0, where a bilinear face has them; areas
/// for square cells (edge `cell`, m).
inline ContactPoints top_points(Index nx, Index ny, Index nz, int side = 2, double cell = 0.01) {
  ContactPoints points;
  const auto node = [&](Index i, Index j) { return i + (nx + 1) * (j + (ny + 1) * nz); };
  for (Index j = 0; j < ny; ++j)
    for (Index i = 0; i < nx; ++i)
      for (int b = 0; b < side; ++b)
        for (int a = 0; a < side; ++a) {
          const double u = (a + 0.5) / side, v = (b + 0.5) / side;
          for (const auto& [n, w] : {std::pair{node(i, j), (1 - u) * (1 - v)},
                                     {node(i + 1, j), u * (1 - v)},
                                     {node(i, j + 1), (1 - u) * v},
                                     {node(i + 1, j + 1), u * v}})
            points.weights.values.push_back({n, w, w});
          points.weights.push_row();
          points.area.push_back(cell * cell / (side * side));
          points.wall.push_back(0);
          points.offset.push_back(0.0);
        }
  return points;
}

}  // namespace glossa::test
