#include "contact/wall_topology.hpp"

#include <limits>

#include "contact/rim_loops.hpp"
#include "walls.hpp"

namespace glossa::test {
namespace {

int edges_of(const WallTopology& wall, FeatureKind kind) {
  return int(std::count_if(wall.edges.begin(), wall.edges.end(), [&](const WallEdge& e) { return e.kind == kind; }));
}

}  // namespace

TEST_CASE("wall topology: edges are interior, rim or inconsistent") {
  const WallTopology open = wall_topology(square(3));
  CHECK(edges_of(open, FeatureKind::rim) == 12);
  CHECK(edges_of(open, FeatureKind::interior) == 9 + 12);
  CHECK_FALSE(open.closed());
  CHECK(wall_topology(box(Vector3(1, 2, 3))).closed());

  WallSurface turned = square(3);
  std::swap(turned.triangles[8][0], turned.triangles[8][1]);  // the lower triangle of the middle cell
  const WallTopology wall = wall_topology(turned);
  CHECK(edges_of(wall, FeatureKind::inconsistent) == 3);
  CHECK(std::count(wall.vertex_kinds.begin(), wall.vertex_kinds.end(), FeatureKind::inconsistent) == 3);

  WallSurface doubled = square(3);
  doubled.triangles.push_back(doubled.triangles[8]);
  CHECK(edges_of(wall_topology(doubled), FeatureKind::inconsistent) == 3);
}

TEST_CASE("wall topology: vertices at one place are welded, also in a chain and across cells of any rounding") {
  WallSurface wall = square(2);
  WallSurface apart;
  Random random(5);
  for (const Triangle& t : wall.triangles)
    for (const Index v : t) {
      apart.vertices.push_back(wall.vertices[static_cast<std::size_t>(v)] +
                               4e-8 * Vector3(random(-1, 1), random(-1, 1), random(-1, 1)).normalized());
      if (v == t[2]) {
        const auto n = Index(apart.vertices.size());
        apart.triangles.push_back({n - 3, n - 2, n - 1});
      }
    }
  const WallTopology welded = wall_topology(apart);
  CHECK(welded.vertices.size() == 9);
  CHECK(edges_of(welded, FeatureKind::rim) == 8);
  CHECK(edges_of(welded, FeatureKind::inconsistent) == 0);
  // 2e-7 apart stays apart.
  wall.vertices.push_back(wall.vertices[4] + Vector3(0, 0, 2e-7));
  wall.triangles[0] = {9, wall.triangles[0][1], wall.triangles[0][2]};
  CHECK(wall_topology(wall).vertices.size() == 10);
}

TEST_CASE("wall topology: the same for every order of vertices and triangles") {
  const WallSurface surface = sphere(0.01, 7);
  const WallTopology wall = wall_topology(surface);
  const WallSurface other = shuffled(surface, 11);
  const WallTopology same = wall_topology(other);
  CHECK(wall.vertices == same.vertices);
  CHECK(wall.triangles == same.triangles);
  CHECK(wall.vertex_normals == same.vertex_normals);
  CHECK(wall.source != same.source);
  // source leads back to the triangle given.
  for (const std::size_t t : {std::size_t{0}, std::size_t{5}, wall.source.size() - 1}) {
    Vector3 centre = Vector3::Zero(), given = Vector3::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      centre += same.vertices[static_cast<std::size_t>(same.triangles[t][k])];
      given += other.vertices[static_cast<std::size_t>(other.triangles[static_cast<std::size_t>(same.source[t])][k])];
    }
    CHECK_WITHIN((centre - given).norm(), 1e-16);
  }
}

TEST_CASE("wall topology: pseudo-normals at the corner of a box are its diagonal, whatever the triangles there") {
  const WallTopology wall = wall_topology(box(Vector3(0.01, 0.01, 0.01)));
  for (std::size_t v = 0; v < 8; ++v)
    CHECK_WITHIN((wall.vertex_normals[v].normalized() - wall.vertices[v].normalized()).norm(), 1e-15);
}

TEST_CASE("wall topology: refusals name what and where") {
  const auto message = [](auto&& change) -> std::string {
    WallSurface wall = square(2);
    change(wall);
    try {
      static_cast<void>(wall_topology(wall));
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  CHECK(message([](WallSurface&) {}) == "accepted");
  CHECK(message([](WallSurface& w) { w.triangles.clear(); }) == "wall: at least one triangle is needed");
  CHECK(message([](WallSurface& w) { w.vertices[3].y() = std::numeric_limits<double>::quiet_NaN(); }) ==
        "wall vertex 3: its coordinates must be finite");
  CHECK(message([](WallSurface& w) { w.triangles[2][1] = 9; }) == "wall triangle 2: vertex 9 is outside 0..8");
  CHECK(message([](WallSurface& w) { w.triangles[2][1] = -1; }) == "wall triangle 2: vertex -1 is outside 0..8");
  CHECK(message([](WallSurface& w) { w.triangles[2][1] = w.triangles[2][0]; }).find("wall triangle 2: two of its") ==
        0);
  CHECK(message([](WallSurface& w) {
          w.vertices[4] = 0.5 * (w.vertices[0] + w.vertices[1]);
        }).find("corners lie on one line") != std::string::npos);
}

TEST_CASE("rim loops: the longest of a sheet is its outer rim, the others are holes") {
  WallSurface wall = square(6);
  const auto drop = [&](int i, int j) {
    for (int k = 0; k < 2; ++k) wall.triangles[static_cast<std::size_t>(2 * (6 * i + j) + k)] = {-1, -1, -1};
  };
  drop(1, 1);
  drop(2, 2);  // meets the hole before in a vertex: one hole, pinched
  drop(4, 1);
  std::erase(wall.triangles, Triangle{-1, -1, -1});
  const WallTopology topology = wall_topology(wall);
  const Rims rims = rim_loops(topology);
  REQUIRE(rims.loops.size() == 3);
  int outer = 0;
  for (const RimLoop& loop : rims.loops) {
    CHECK(loop.sheet == 0);
    CHECK(loop.edges.size() == loop.vertices.size());
    CHECK((loop.outer ? loop.edges.size() == 24 : loop.edges.size() == 4 || loop.edges.size() == 8));
    CHECK_WITHIN(std::abs(loop.length - double(loop.edges.size()) * 0.04 / 6), 1e-15);
    outer += loop.outer;
  }
  CHECK(outer == 1);
  CHECK(std::count(rims.loop_of_edge.begin(), rims.loop_of_edge.end(), -1) ==
        edges_of(topology, FeatureKind::interior));

  WallSurface two = square(2);
  const WallSurface second = square(3);
  for (const Vector3& v : second.vertices) two.vertices.push_back(v + Vector3(0, 0, 0.01));
  for (Triangle t : second.triangles) {
    for (Index& v : t) v += 9;
    two.triangles.push_back(t);
  }
  const Rims apart = rim_loops(wall_topology(two));
  REQUIRE(apart.loops.size() == 2);
  CHECK(apart.loops[0].sheet != apart.loops[1].sheet);
  CHECK((apart.loops[0].outer && apart.loops[1].outer));
  CHECK(rim_loops(wall_topology(box(Vector3(1, 1, 1)))).loops.empty());
}

TEST_CASE("rim loops: faces turned round do not break a loop") {
  WallSurface wall = square(4);
  for (std::size_t t = 0; t < 9; ++t) std::swap(wall.triangles[t][0], wall.triangles[t][1]);
  const Rims rims = rim_loops(wall_topology(wall));
  REQUIRE(rims.loops.size() == 1);
  CHECK(rims.loops[0].edges.size() == 16);
}

}  // namespace glossa::test
