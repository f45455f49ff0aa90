#include "contact/nearest_feature.hpp"
#include "contact/near_triangles.hpp"

#include "walls.hpp"

namespace glossa::test {
namespace {

Vector3 random_point(Random& random, double size) {
  const double x = random(-size, size), y = random(-size, size);
  return {x, y, random(-size, size)};
}

TriangleShape shape_of(const Vector3& a, const Vector3& b, const Vector3& c) {
  const Vector3 ab = b - a, ac = c - a;
  return {a, ab, ac, ab.cross(ac).normalized(), ab.squaredNorm(), ab.dot(ac), ac.squaredNorm()};
}

}  // namespace

TEST_CASE("nearest feature: nearest point of a triangle, in every region") {
  Random random(3);
  std::array<int, 7> found{};
  for (int k = 0; k < 2000; ++k) {
    const Vector3 a = random_point(random, 1), b = random_point(random, 1), c = random_point(random, 1);
    const Vector3 x = random_point(random, 2);
    const TriangleShape shape = shape_of(a, b, c);
    if (shape.ab.cross(shape.ac).norm() < 0.05) continue;
    const auto q = shape.nearest(x);
    ++found[static_cast<std::size_t>(q.part)];
    const Vector3 point = a + q.v * shape.ab + q.w * shape.ac, away = x - point;
    // q is the nearest: no corner of a convex set is farther along `away`; with its distance, inside, on its part.
    for (const Vector3& corner : {a, b, c}) CHECK(away.dot(corner - point) < 1e-13);
    CHECK_WITHIN(std::abs(q.squared - away.squaredNorm()), 1e-13);
    const std::array<double, 3> share{1.0 - q.v - q.w, q.v, q.w};
    CHECK_WITHIN(-*std::min_element(share.begin(), share.end()), 1e-15);
    const auto zero = [&](int corner) { return std::abs(share[static_cast<std::size_t>(corner)]) < 1e-15; };
    if (q.part < 3) CHECK(std::abs(share[static_cast<std::size_t>(q.part)] - 1.0) < 1e-15);
    if (q.part >= 3 && q.part < 6) CHECK(zero((q.part - 3 + 2) % 3));
  }
  for (const int count : found) CHECK(count > 50);
}

TEST_CASE("nearest feature: the tree finds what looking at every triangle finds") {
  Random random(4);
  const WallSurface surface = patch(9, 11, [&](double u, double v) -> Vector3 {
    return {0.05 * u, 0.04 * v, 0.01 * std::sin(7 * u) * std::cos(5 * v) + random(0, 2e-3)};
  });
  const NearestFeature wall(surface);
  for (int k = 0; k < 500; ++k) {
    const Vector3 x = random_point(random, 0.06);
    const Nearest nearest = wall(x);
    double least = 1.0;
    for (const TriangleShape& shape : wall.shapes()) least = std::min(least, shape.squared_distance(x));
    CHECK(std::abs(nearest.distance) == doctest::Approx(std::sqrt(least)).epsilon(1e-14));
    CHECK_WITHIN(std::abs((x - nearest.point).norm() - std::sqrt(least)), 1e-16);
    double end = 1.0;
    for (const SegmentShape& shape : wall.ends()) end = std::min(end, shape.squared_distance(x));
    CHECK(wall.nearest_end(x).squared == end);
    CHECK(wall.nearest_end(x, 0.999 * std::sqrt(end)).item == -1);
    CHECK((nearest.kind == FeatureKind::rim) == (end <= least * (1 + 1e-14)));
    CHECK((nearest.rim_loop == 0) == (nearest.kind == FeatureKind::rim));
  }
}

TEST_CASE("nearest feature: near triangles of a brick are the nearest of all, ties to the lowest number") {
  Random random(5);
  const WallSurface rough = patch(19, 21, [&](double u, double v) -> Vector3 {
    return {0.05 * u, 0.04 * v, 0.01 * std::sin(7 * u) * std::cos(5 * v) + random(0, 2e-3)};
  });
  const WallSurface large = patch(1, 1, [](double u, double v) -> Vector3 { return {u - 0.5, v - 0.5, 0.002}; });
  for (const WallSurface& surface : {rough, box(Vector3(0.02, 0.01, 0.004)), sphere(0.01, 20), square(8), large}) {
    const NearestFeature wall(surface);
    const std::vector<TriangleFrame> frames(wall.shapes().begin(), wall.shapes().end());
    NearTriangles near(wall, frames);
    for (int k = 0; k < 60; ++k) {
      const double spacing = k % 2 == 0 ? 8e-4 : 1.3e-3;
      // Every third on a lattice, where distances are often equal.
      Vector3 first = random_point(random, 0.025);
      if (k % 3 == 0) first = 1e-3 * (1e3 * first).array().round();
      std::array<NearTriangles::Points, 8> points;
      NearTriangles::Points centres;
      const auto bits = [](std::size_t number) -> Vector3 {
        return {double(number >> 2 & 1), double(number >> 1 & 1), double(number & 1)};
      };
      for (std::size_t c = 0; c < 8; ++c) {
        centres[c] = first + spacing * (2.0 * bits(c) + Vector3::Constant(0.5));
        for (std::size_t p = 0; p < 8; ++p) points[c][p] = first + spacing * (2.0 * bits(c) + bits(p));
      }
      const Vector3 centre = first + Vector3::Constant(1.5 * spacing);
      NearTriangles::Results results;
      near.gather(centre, 1.5 * spacing, wall.nearest_triangle(centre).item);
      near.nearest(points, centres, 0.5 * spacing, results);
      for (std::size_t c = 0; c < 8; ++c)
        for (std::size_t p = 0; p < 8; ++p) {
          BoxTree::Found least{-1, 1e9};
          for (std::size_t t = 0; t < wall.shapes().size(); ++t)
            if (const double squared = wall.shapes()[t].squared_distance(points[c][p]); squared < least.squared)
              least = {static_cast<Index>(t), squared};
          CHECK(results[c][p].triangle == least.item);
          CHECK(results[c][p].point.squared == least.squared);
        }
    }
  }
}

TEST_CASE("nearest feature: inside and outside of a closed wall, also where corners and edges are nearest") {
  const Vector3 size(0.02, 0.01, 0.004);
  const NearestFeature wall(box(size));
  Random random(6);
  int inside = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vector3 x = random_point(random, 0.015);
    const Vector3 beyond = x.cwiseAbs() - 0.5 * size;
    const double exact = beyond.maxCoeff() < 0.0 ? beyond.maxCoeff() : beyond.cwiseMax(0.0).norm();
    CHECK_WITHIN(std::abs(wall(x).distance - exact), 1e-16);
    inside += exact < 0.0;
  }
  CHECK(inside > 20);
}

TEST_CASE("nearest feature: inside and outside of a spike, where face normals alone would err at edges and tips") {
  const std::array<Vector3, 4> p{Vector3(0, 0, 0), Vector3(1e-3, 0, 9e-3), Vector3(-1e-3, 1e-3, 9e-3),
                                 Vector3(0, -2e-3, 8e-3)};
  Matrix3 sides;
  sides << p[1] - p[0], p[2] - p[0], p[3] - p[0];
  REQUIRE(sides.determinant() > 0.0);
  const NearestFeature spike({{p.begin(), p.end()}, {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}}});
  Random random(7);
  std::array<int, 3> seen{};  // inside, outside nearest to an edge, to a corner
  for (int k = 0; k < 10000; ++k) {
    const Vector3 x = Vector3(0, 0, 4e-3) + random_point(random, 6e-3);
    const Vector3 share = sides.inverse() * (x - p[0]);
    const bool inside = share.minCoeff() > 0.0 && share.sum() < 1.0;
    const Nearest nearest = spike(x);
    CHECK((nearest.distance < 0.0) == inside);
    const Vector3 at = sides.inverse() * (nearest.point - p[0]);
    const auto zeros = (at.array().abs() < 1e-9).count() + (std::abs(1.0 - at.sum()) < 1e-9);
    ++seen[inside ? 0 : zeros == 3 ? 2 : 1];
  }
  for (const int count : seen) CHECK(count > 20);
}

TEST_CASE("nearest feature: rims, holes and turned faces are told") {
  WallSurface surface = square(8);
  surface.triangles.erase(surface.triangles.begin() + 2 * (8 * 3 + 3), surface.triangles.begin() + 2 * (8 * 3 + 3) + 2);
  const NearestFeature wall(surface);
  const Vector3 in_hole(-2.5e-3, -2.5e-3, 1e-3);
  CHECK(wall(in_hole).kind == FeatureKind::rim);
  CHECK_FALSE(wall.rims().loops[static_cast<std::size_t>(wall(in_hole).rim_loop)].outer);
  CHECK(wall.rims().loops[static_cast<std::size_t>(wall(Vector3(0.03, 0, 1e-3)).rim_loop)].outer);
  CHECK(wall(Vector3(0.01, 0.01, -1e-3)).distance == doctest::Approx(-1e-3));
  const Nearest over = wall(Vector3(0.012, 0.013, 2e-3));
  CHECK(over.kind == FeatureKind::interior);
  Vector3 low = over.point, high = low;
  for (const Index v : surface.triangles[static_cast<std::size_t>(over.triangle)]) {
    low = low.cwiseMin(surface.vertices[static_cast<std::size_t>(v)]);
    high = high.cwiseMax(surface.vertices[static_cast<std::size_t>(v)]);
  }
  CHECK((high - low).maxCoeff() < 5.1e-3);  // the number is that of the triangle under the point
  std::swap(surface.triangles[20][0], surface.triangles[20][1]);
  Vector3 edge = Vector3::Zero();
  for (const int k : {0, 1})
    edge += 0.5 * surface.vertices[static_cast<std::size_t>(surface.triangles[20][std::size_t(k)])];
  CHECK(NearestFeature(surface)(edge + Vector3(0, 0, 1e-3)).kind == FeatureKind::inconsistent);
}

}  // namespace glossa::test
