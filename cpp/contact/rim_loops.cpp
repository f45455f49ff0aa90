#include "contact/rim_loops.hpp"

#include <algorithm>
#include <numeric>

namespace glossa {
namespace {

/// Faces of every edge.
Rows<Index> faces_of_edges(const WallTopology& wall) {
  Rows<Index> faces;
  faces.start.assign(wall.edges.size() + 1, 0);
  for (const auto& sides : wall.sides)
    for (const Index e : sides) ++faces.start[static_cast<std::size_t>(e) + 1];
  std::partial_sum(faces.start.begin(), faces.start.end(), faces.start.begin());
  faces.values.resize(3 * wall.triangles.size());
  std::vector<Index> next(faces.start.begin(), faces.start.end() - 1);
  for (std::size_t t = 0; t < wall.sides.size(); ++t)
    for (const Index e : wall.sides[t])
      faces.values[static_cast<std::size_t>(next[static_cast<std::size_t>(e)]++)] = static_cast<Index>(t);
  return faces;
}

const WallEdge& edge(const WallTopology& wall, Index e) {
  return wall.edges[static_cast<std::size_t>(e)];
}

/// The side of face `t` other than `e` that meets vertex `v`.
Index other_side(const WallTopology& wall, Index t, Index e, Index v) {
  for (const Index side : wall.sides[static_cast<std::size_t>(t)])
    if (side != e && (edge(wall, side).a == v || edge(wall, side).b == v)) return side;
  return e;
}

/// The edge that ends the fan of faces around `v` which begins with rim `e`; edges of three faces end it too.
Index across_fan(const WallTopology& wall, const Rows<Index>& faces, Index e, Index v) {
  Index t = *faces.begin(e);
  Index side = other_side(wall, t, e, v);
  while (faces.length(side) == 2) {
    t = faces.begin(side)[0] == t ? faces.begin(side)[1] : faces.begin(side)[0];
    side = other_side(wall, t, side, v);
  }
  return side;
}

/// Number of the connected piece of every triangle, joined across edges.
std::vector<Index> sheets(const WallTopology& wall, const Rows<Index>& faces) {
  std::vector<Index> sheet(wall.triangles.size(), -1);
  Index count = 0;
  std::vector<Index> stack;
  for (std::size_t seed = 0; seed < sheet.size(); ++seed) {
    if (sheet[seed] >= 0) continue;
    sheet[seed] = count;
    stack.assign(1, static_cast<Index>(seed));
    while (!stack.empty()) {
      const Index t = stack.back();
      stack.pop_back();
      for (const Index e : wall.sides[static_cast<std::size_t>(t)])
        for (const Index* face = faces.begin(e); face != faces.end(e); ++face)
          if (sheet[static_cast<std::size_t>(*face)] < 0) {
            sheet[static_cast<std::size_t>(*face)] = count;
            stack.push_back(*face);
          }
    }
    ++count;
  }
  return sheet;
}

RimLoop trace(const WallTopology& wall, const Rows<Index>& faces, Index first, std::vector<bool>& seen) {
  RimLoop loop;
  Index e = first, v = edge(wall, first).a;
  while (edge(wall, e).kind == FeatureKind::rim && !seen[static_cast<std::size_t>(e)]) {
    seen[static_cast<std::size_t>(e)] = true;
    loop.edges.push_back(e);
    loop.vertices.push_back(v);
    const Vector3& p = wall.vertices[static_cast<std::size_t>(edge(wall, e).a)];
    const Vector3& q = wall.vertices[static_cast<std::size_t>(edge(wall, e).b)];
    loop.length += (q - p).norm();
    v = edge(wall, e).a == v ? edge(wall, e).b : edge(wall, e).a;
    e = across_fan(wall, faces, e, v);
  }
  return loop;
}

}  // namespace

Rims rim_loops(const WallTopology& wall) {
  const Rows<Index> faces = faces_of_edges(wall);
  const std::vector<Index> sheet = sheets(wall, faces);
  Rims rims;
  rims.loop_of_edge.assign(wall.edges.size(), -1);
  rims.loop_of_vertex.assign(wall.vertices.size(), -1);
  std::vector<bool> seen(wall.edges.size(), false);
  for (std::size_t e = 0; e < wall.edges.size(); ++e) {
    if (wall.edges[e].kind != FeatureKind::rim || seen[e]) continue;
    const auto number = static_cast<Index>(rims.loops.size());
    RimLoop loop = trace(wall, faces, static_cast<Index>(e), seen);
    loop.sheet = sheet[static_cast<std::size_t>(*faces.begin(static_cast<Index>(e)))];
    for (const Index part : loop.edges) rims.loop_of_edge[static_cast<std::size_t>(part)] = number;
    for (const Index v : loop.vertices)
      if (rims.loop_of_vertex[static_cast<std::size_t>(v)] < 0)
        rims.loop_of_vertex[static_cast<std::size_t>(v)] = number;
    rims.loops.push_back(std::move(loop));
  }
  for (RimLoop& loop : rims.loops)
    loop.outer = std::none_of(rims.loops.begin(), rims.loops.end(), [&](const RimLoop& other) {
      return other.sheet == loop.sheet &&
             (other.length > loop.length || (other.length == loop.length && &other < &loop));
    });
  return rims;
}

}  // namespace glossa
