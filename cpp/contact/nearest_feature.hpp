// The nearest point of a wall: exactly, on its triangles.
#pragma once

#include <limits>

#include "contact/box_tree.hpp"
#include "contact/rim_loops.hpp"
#include "contact/simplex_shapes.hpp"

namespace glossa {

/// What lies nearest to a point.
struct Nearest {
  double distance;   ///< m; negative where the feature is interior and the point behind it
  Index triangle;    ///< in the order the wall was given
  FeatureKind kind;  ///< rim, inconsistent: no side is told there
  Index rim_loop;    ///< of rims(); -1 unless the kind is rim
  Vector3 point;     ///< on the wall
};

/// A wall prepared for questions about single points.
class NearestFeature {
 public:
  /// InputError where wall_topology refuses the surface.
  explicit NearestFeature(const WallSurface& surface);

  [[nodiscard]] Nearest operator()(const Vector3& x) const;

  [[nodiscard]] const WallTopology& topology() const { return topology_; }
  [[nodiscard]] const Rims& rims() const { return rims_; }
  /// The triangles of the topology, and a tree over them.
  [[nodiscard]] const std::vector<TriangleShape>& shapes() const { return shapes_; }
  [[nodiscard]] const BoxTree& tree() const { return tree_; }
  /// Edges that are not interior, where the wall's sheets end, and a tree over them.
  [[nodiscard]] const std::vector<SegmentShape>& ends() const { return ends_; }
  [[nodiscard]] const BoxTree& end_tree() const { return end_tree_; }

  [[nodiscard]] const TriangleShape& shape(Index triangle) const { return shapes_[static_cast<std::size_t>(triangle)]; }
  /// `squared`: a bound that is known, m2.
  [[nodiscard]] BoxTree::Found nearest_triangle(const Vector3& x,
                                                double squared = std::numeric_limits<double>::infinity()) const;
  /// None if there is none within `bound` (m).
  [[nodiscard]] BoxTree::Found nearest_end(const Vector3& x,
                                           double bound = std::numeric_limits<double>::infinity()) const;
  [[nodiscard]] FeatureKind kind(Index triangle, int part) const;
  /// Whether x is behind the surface, given its nearest point there.
  [[nodiscard]] bool behind(const Vector3& x, Index triangle, const TriangleShape::Point& nearest) const;

 private:
  WallTopology topology_;
  Rims rims_;
  std::vector<TriangleShape> shapes_;
  std::vector<SegmentShape> ends_;
  BoxTree tree_, end_tree_;
};

}  // namespace glossa
