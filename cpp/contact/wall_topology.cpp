#include "contact/wall_topology.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.hpp"

namespace glossa {
namespace {

constexpr double flat_triangle = 1e-12;  // twice the area over the square of the longest side

bool before(const Vector3& p, const Vector3& q) {
  return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
}

void check(const WallSurface& surface) {
  require(!surface.triangles.empty(), "wall: at least one triangle is needed");
  for (std::size_t v = 0; v < surface.vertices.size(); ++v)
    require(surface.vertices[v].allFinite(), "wall vertex " + std::to_string(v) + ": its coordinates must be finite");
  const auto count = static_cast<Index>(surface.vertices.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (const Index v : surface.triangles[t])
      require(v >= 0 && v < count, "wall triangle " + std::to_string(t) + ": vertex " + std::to_string(v) +
                                       " is outside 0.." + std::to_string(count - 1));
}

/// New number of every vertex; fills `welded` with one position, the lexicographically first, of every cluster.
std::vector<Index> weld(const std::vector<Vector3>& vertices, std::vector<Vector3>& welded) {
  std::vector<std::size_t> order(vertices.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t p, std::size_t q) { return before(vertices[p], vertices[q]); });
  std::vector<std::size_t> root(order.size());  // by place in the order; a root is the first of its cluster
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&](std::size_t place) {
    while (root[place] != place) place = root[place] = root[root[place]];
    return place;
  };
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t j = i + 1; j < order.size(); ++j) {
      const Vector3 gap = vertices[order[j]] - vertices[order[i]];
      if (gap.x() > welding_distance) break;
      if (gap.squaredNorm() > welding_distance * welding_distance) continue;
      const std::size_t p = find(i), q = find(j);
      root[std::max(p, q)] = std::min(p, q);
    }
  std::vector<Index> number(order.size()), of_root(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (find(i) == i) {
      of_root[i] = static_cast<Index>(welded.size());
      welded.push_back(vertices[order[i]]);
    }
    number[order[i]] = of_root[find(i)];
  }
  return number;
}

void sort_triangles(const WallSurface& surface, const std::vector<Index>& number, WallTopology& wall) {
  std::vector<Triangle> turned(surface.triangles.size());
  for (std::size_t t = 0; t < turned.size(); ++t) {
    std::transform(surface.triangles[t].begin(), surface.triangles[t].end(), turned[t].begin(),
                   [&](Index v) { return number[static_cast<std::size_t>(v)]; });
    std::rotate(turned[t].begin(), std::min_element(turned[t].begin(), turned[t].end()), turned[t].end());
    const auto& [a, b, c] = turned[t];
    require(a != b && b != c && c != a,
            "wall triangle " + std::to_string(t) + ": two of its corners are at the same place; remove the triangle");
  }
  wall.source.resize(turned.size());
  std::iota(wall.source.begin(), wall.source.end(), 0);
  const auto key = [&](Index t) -> const Triangle& { return turned[static_cast<std::size_t>(t)]; };
  std::stable_sort(wall.source.begin(), wall.source.end(), [&](Index p, Index q) { return key(p) < key(q); });
  for (const Index t : wall.source) wall.triangles.push_back(key(t));
}

const Vector3& vertex(const WallTopology& wall, Index v) {
  return wall.vertices[static_cast<std::size_t>(v)];
}

void compute_face_normals(WallTopology& wall) {
  for (std::size_t t = 0; t < wall.triangles.size(); ++t) {
    const auto& [a, b, c] = wall.triangles[t];
    const Vector3 ab = vertex(wall, b) - vertex(wall, a), ac = vertex(wall, c) - vertex(wall, a);
    const Vector3 normal = ab.cross(ac);
    const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
    require(normal.norm() > flat_triangle * longest,
            "wall triangle " + std::to_string(wall.source[t]) + ": its corners lie on one line; remove the triangle");
    wall.face_normals.push_back(normal.normalized());
  }
}

/// Every side of every triangle, sorted by edge.
struct Side {
  Index a, b, triangle, side;
  bool upwards;  // the triangle runs from a to b
  [[nodiscard]] std::array<Index, 4> key() const { return {a, b, triangle, side}; }
};

void join_sides(WallTopology& wall) {
  std::vector<Side> sides;
  for (std::size_t t = 0; t < wall.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const Index p = wall.triangles[t][k], q = wall.triangles[t][(k + 1) % 3];
      sides.push_back({std::min(p, q), std::max(p, q), static_cast<Index>(t), static_cast<Index>(k), p < q});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& p, const Side& q) { return p.key() < q.key(); });
  wall.sides.resize(wall.triangles.size());
  for (std::size_t first = 0, last = 0; first < sides.size(); first = last) {
    WallEdge edge{sides[first].a, sides[first].b, FeatureKind::interior, Vector3::Zero()};
    for (; last < sides.size() && sides[last].a == edge.a && sides[last].b == edge.b; ++last) {
      edge.normal += wall.face_normals[static_cast<std::size_t>(sides[last].triangle)];
      wall.sides[static_cast<std::size_t>(sides[last].triangle)][static_cast<std::size_t>(sides[last].side)] =
          static_cast<Index>(wall.edges.size());
    }
    if (last - first == 1)
      edge.kind = FeatureKind::rim;
    else if (last - first > 2 || sides[first].upwards == sides[first + 1].upwards)
      edge.kind = FeatureKind::inconsistent;
    wall.edges.push_back(edge);
  }
}

void compute_vertex_normals(WallTopology& wall) {
  wall.vertex_normals.assign(wall.vertices.size(), Vector3::Zero());
  for (std::size_t t = 0; t < wall.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& corner = wall.triangles[t];
      const Vector3 p = vertex(wall, corner[(k + 1) % 3]) - vertex(wall, corner[k]);
      const Vector3 q = vertex(wall, corner[(k + 2) % 3]) - vertex(wall, corner[k]);
      wall.vertex_normals[static_cast<std::size_t>(corner[k])] +=
          std::atan2(p.cross(q).norm(), p.dot(q)) * wall.face_normals[t];
    }
  wall.vertex_kinds.assign(wall.vertices.size(), FeatureKind::interior);
  for (const WallEdge& edge : wall.edges)
    for (const Index v : {edge.a, edge.b}) {
      FeatureKind& kind = wall.vertex_kinds[static_cast<std::size_t>(v)];
      kind = std::max(kind, edge.kind);
    }
}

}  // namespace

bool WallTopology::closed() const {
  return std::all_of(edges.begin(), edges.end(), [](const WallEdge& e) { return e.kind == FeatureKind::interior; });
}

WallTopology wall_topology(const WallSurface& surface) {
  check(surface);
  WallTopology wall;
  const std::vector<Index> number = weld(surface.vertices, wall.vertices);
  sort_triangles(surface, number, wall);
  compute_face_normals(wall);
  join_sides(wall);
  compute_vertex_normals(wall);
  return wall;
}

}  // namespace glossa
