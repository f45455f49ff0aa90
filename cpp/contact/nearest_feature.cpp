#include "contact/nearest_feature.hpp"

#include <cmath>

namespace glossa {

NearestFeature::NearestFeature(const WallSurface& surface)
    : topology_(wall_topology(surface)), rims_(rim_loops(topology_)) {
  const auto vertex = [&](Index v) -> const Vector3& { return topology_.vertices[static_cast<std::size_t>(v)]; };
  std::vector<Box> boxes(topology_.triangles.size());
  for (std::size_t t = 0; t < boxes.size(); ++t) {
    const auto& [a, b, c] = topology_.triangles[t];
    for (const Index v : topology_.triangles[t]) boxes[t].add(vertex(v));
    const Vector3 ab = vertex(b) - vertex(a), ac = vertex(c) - vertex(a);
    shapes_.push_back({vertex(a), ab, ac, topology_.face_normals[t], ab.squaredNorm(), ab.dot(ac), ac.squaredNorm()});
  }
  tree_ = BoxTree(boxes);
  boxes.clear();
  for (const WallEdge& edge : topology_.edges) {
    if (edge.kind == FeatureKind::interior) continue;
    const Vector3 ab = vertex(edge.b) - vertex(edge.a);
    ends_.push_back({vertex(edge.a), ab, ab.squaredNorm()});
    boxes.emplace_back();
    boxes.back().add(vertex(edge.a));
    boxes.back().add(vertex(edge.b));
  }
  end_tree_ = BoxTree(boxes);
}

BoxTree::Found NearestFeature::nearest_triangle(const Vector3& x, double squared) const {
  return tree_.nearest(
      x, [&](Index t) { return shape(t).squared_distance(x); }, squared);
}

BoxTree::Found NearestFeature::nearest_end(const Vector3& x, double bound) const {
  return end_tree_.nearest(
      x, [&](Index e) { return ends_[static_cast<std::size_t>(e)].squared_distance(x); }, bound * bound);
}

FeatureKind NearestFeature::kind(Index triangle, int part) const {
  const auto t = static_cast<std::size_t>(triangle);
  if (part == 6) return FeatureKind::interior;
  if (part >= 3)
    return topology_.edges[static_cast<std::size_t>(topology_.sides[t][static_cast<std::size_t>(part) - 3])].kind;
  return topology_.vertex_kinds[static_cast<std::size_t>(topology_.triangles[t][static_cast<std::size_t>(part)])];
}

bool NearestFeature::behind(const Vector3& x, Index triangle, const TriangleShape::Point& nearest) const {
  const auto t = static_cast<std::size_t>(triangle);
  const auto part = static_cast<std::size_t>(nearest.part);
  const TriangleShape& shape = shapes_[t];
  const Vector3 away = x - (shape.a + nearest.v * shape.ab + nearest.w * shape.ac);
  if (part == 6) return shape.normal.dot(x - shape.a) < 0.0;
  if (part >= 3) return topology_.edges[static_cast<std::size_t>(topology_.sides[t][part - 3])].normal.dot(away) < 0.0;
  return topology_.vertex_normals[static_cast<std::size_t>(topology_.triangles[t][part])].dot(away) < 0.0;
}

Nearest NearestFeature::operator()(const Vector3& x) const {
  const Index triangle = nearest_triangle(x).item;
  const auto t = static_cast<std::size_t>(triangle);
  const TriangleShape::Point q = shapes_[t].nearest(x);
  Nearest result{std::sqrt(q.squared), topology_.source[t], kind(triangle, q.part), -1,
                 shapes_[t].a + q.v * shapes_[t].ab + q.w * shapes_[t].ac};
  if (result.kind == FeatureKind::interior && behind(x, triangle, q)) result.distance = -result.distance;
  if (result.kind == FeatureKind::rim) {
    const auto part = static_cast<std::size_t>(q.part);
    result.rim_loop = part >= 3 ? rims_.loop_of_edge[static_cast<std::size_t>(topology_.sides[t][part - 3])]
                                : rims_.loop_of_vertex[static_cast<std::size_t>(topology_.triangles[t][part])];
  }
  return result;
}

}  // namespace glossa
