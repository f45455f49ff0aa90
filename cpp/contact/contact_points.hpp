// Points of the smooth tongue surface that may touch walls.
#pragma once

#include <vector>

#include "core/types.hpp"

namespace glossa {

/// Share of a node in a point of the surface. In a mirrored half a node also stands for its image, whose lateral (y)
/// coordinate has the other sign: `across` weighs y, `along` x and z. Equal in a whole body.
struct PointWeight {
  Index node;
  double along;
  double across;

  [[nodiscard]] Vector3 diagonal() const { return {along, across, along}; }
};

/// One entry per pair of a surface point and a wall that it may touch.
struct ContactPoints {
  Rows<PointWeight> weights;
  std::vector<double> area;    ///< m2 of the surface at rest that the point carries
  std::vector<Index> wall;     ///< number of the wall
  std::vector<double> offset;  ///< m added to the wall's distance, to clear an overlap at rest

  [[nodiscard]] Index count() const { return weights.size(); }
  /// Position (m) of point k for the given node positions.
  [[nodiscard]] Vector3 position(Index k, const NodeField& positions) const {
    Vector3 sum = Vector3::Zero();
    for (const PointWeight* w = weights.begin(k); w != weights.end(k); ++w)
      sum += w->diagonal().cwiseProduct(at(positions, w->node));
    return sum;
  }
};

}  // namespace glossa
