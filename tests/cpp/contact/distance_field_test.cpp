#include "contact/distance_field.hpp"

#include "walls.hpp"

namespace glossa::test {
namespace {

constexpr double mm = 1e-3;

DistanceField field_of(const WallSurface& wall, double half = 0.025, double spacing = mm, int threads = 1,
                       double band = 6 * mm) {
  return {wall, {spacing, band, Vector3::Constant(-half), Vector3::Constant(half), threads}};
}

Vector3 random_point(Random& random, double size) {
  const double x = random(-size, size), y = random(-size, size);
  return {x, y, random(-size, size)};
}

/// Largest |f - exact| at random points x of a ball around the origin for which exact(x) is within `reach` of 0.
template <class Exact>
double worst(const DistanceField& field, Exact&& exact, double reach, double size = 0.02) {
  Random random(12);
  double largest = 0.0;
  int seen = 0;
  for (int k = 0; k < 20000; ++k) {
    const Vector3 x = random_point(random, size);
    const double d = exact(x);
    if (!(std::abs(d) < reach)) continue;
    largest = std::max(largest, std::abs(field.distance(x) - d));
    ++seen;
  }
  REQUIRE(seen > 500);
  return largest;
}

/// Largest change of the field over the way along straight lines through the box.
double steepest(const DistanceField& field, double size = 0.018) {
  Random random(13);
  double largest = 0.0;
  for (int line = 0; line < 400; ++line) {
    const Vector3 from = random_point(random, size), to = random_point(random, size);
    const int steps = 1 + int((to - from).norm() / (0.05 * mm));
    double before = field.distance(from);
    for (int k = 1; k <= steps; ++k) {
      const double here = field.distance(from + double(k) / steps * (to - from));
      largest = std::max(largest, std::abs(here - before) * steps / (to - from).norm());
      before = here;
    }
  }
  return largest;
}

}  // namespace

TEST_CASE("distance field: gradient and Hessian are the derivatives of the value") {
  const DistanceField field = field_of(box(Vector3(12, 16, 9) * mm), 0.012);
  Random random(14);
  double steep = 0.0, curved = 0.0;
  for (int k = 0; k < 200; ++k) {
    const Vector3 x = random_point(random, 0.01);
    Vector3 gradient, only;
    Matrix3 hessian;
    const double value = field.value(x, gradient, hessian);
    CHECK(field.distance(x) == value);
    CHECK(field.value(x, only) == value);
    CHECK(only == gradient);
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 step = Vector3::Unit(axis);
      CHECK_WITHIN(std::abs(slope([&](double h) { return field.distance(x + h * step); }, 1e-7) - gradient[axis]),
                   1e-9);
      const auto change = derivative(
          [&](double h) {
            Vector3 g;
            field.value(x + h * step, g);
            return g;
          },
          1e-8);
      CHECK_WITHIN((change - hessian.col(axis)).norm(), 1e-5);  // rounding over the step; of 1000
    }
    steep = std::max(steep, gradient.norm());
    curved = std::max(curved, hessian.norm());
  }
  CHECK(steep > 0.9);
  CHECK(curved > 500.0);
}

TEST_CASE("distance field: accurate on plane, sphere, cylinder and vault") {
  Random random(15);
  const Matrix3 turn = rotation();
  const Vector3 up = turn.col(2);
  // Tilted plane, away from its rim and from the band: a spline holds it exactly.
  const auto height = [&](const Vector3& x) { return up.dot(x); };
  CHECK_WITHIN(worst(field_of(square(1, turn), 0.012, mm, 1, 12 * mm), height, 4 * mm, 4 * mm), 1e-16);
  CHECK_WITHIN(worst(field_of(square(1, turn), 0.012), height, 3 * mm, 8 * mm), 1e-6);
  CHECK_WITHIN(worst(field_of(square(1, turn), 0.012), height, 4 * mm, 8 * mm), 8e-6);

  // Facets of 0.5 mm, 0.74 mm along the diagonal, sag by 7 um.
  const WallSurface ball = sphere(10 * mm, 60);
  const auto ball_distance = [](const Vector3& x) { return x.norm() - 10 * mm; };
  const DistanceField around = field_of(ball, 0.018);
  CHECK_WITHIN(worst(around, ball_distance, 3 * mm), 7e-6);
  CHECK_WITHIN(around.geometric_error(), 5e-6);
  for (int k = 0; k < 50; ++k) {
    const Vector3 n = random_point(random, 1.0).normalized();
    Vector3 gradient;
    Matrix3 hessian;
    around.value(11 * mm * n, gradient, hessian);
    CHECK_WITHIN((gradient - n).norm(), 5e-3);
    CHECK_WITHIN((hessian - (Matrix3::Identity() - n * n.transpose()) / (11 * mm)).norm(), 12.0);  // of 129 per m
  }

  // Half a cylinder seen from inside, 40 mm long; open.
  const WallSurface trough = patch(100, 1, [](double u, double v) -> Vector3 {
    const double a = std::numbers::pi * u;
    return {10 * mm * std::cos(a), 40 * mm * (0.5 - v), -10 * mm * std::sin(a)};
  });
  const auto trough_distance = [](const Vector3& x) {
    const double d = 10 * mm - Vector3(x.x(), 0, x.z()).norm();
    return x.z() < -6 * mm && std::abs(x.y()) < 10 * mm ? d : 1.0;
  };
  CHECK_WITHIN(worst(field_of(trough, 0.02), trough_distance, 3 * mm), 4e-6);

  // A vault z = -c (x^2 + 2 y^2), seen from below: points on normals, less than the least radius of curvature away.
  const double c = 15.0;
  const WallSurface vault = patch(80, 80, [&](double u, double v) -> Vector3 {
    const double x = 30 * mm * (u - 0.5), y = 30 * mm * (0.5 - v);
    return {x, y, -c * (x * x + 2 * y * y)};
  });
  const DistanceField under = field_of(vault, 0.02);
  double error = 0.0;
  for (int k = 0; k < 5000; ++k) {
    const double x = random(-9 * mm, 9 * mm), y = random(-9 * mm, 9 * mm), s = random(-3 * mm, 3 * mm);
    const Vector3 down = -Vector3(2 * c * x, 4 * c * y, 1).normalized();
    const Vector3 foot(x, y, -c * (x * x + 2 * y * y));
    error = std::max(error, std::abs(under.distance(foot + s * down) - s));
  }
  CHECK_WITHIN(error, 8e-6);
}

TEST_CASE("distance field: far away the sign is right and there is no slope") {
  const DistanceField sheet = field_of(square(5));
  const DistanceField body = field_of(box(Vector3(24, 24, 24) * mm));
  Vector3 gradient;
  for (const double z : {-20.0, -10.0, 10.0, 20.0}) {
    CHECK(sheet.value(Vector3(1 * mm, 2 * mm, z * mm), gradient) == doctest::Approx(z < 0 ? -6 * mm : 6 * mm));
    CHECK_WITHIN(gradient.norm(), 1e-13);
  }
  CHECK(body.value(Vector3(0.3 * mm, 0, 0.2 * mm), gradient) == doctest::Approx(-6 * mm));
  CHECK_WITHIN(gradient.norm(), 1e-13);
  CHECK(body.value(Vector3(mm, mm, 24 * mm), gradient) == doctest::Approx(6 * mm));
  CHECK_WITHIN(gradient.norm(), 1e-13);
  CHECK(field_of(reversed(box(Vector3(24, 24, 24) * mm))).distance(Vector3::Zero()) == doctest::Approx(6 * mm));
  // Outside the box; not a number.
  CHECK(sheet.value(Vector3(0, 0, -30 * mm), gradient) == 6 * mm);
  CHECK(gradient.norm() == 0.0);
  CHECK(std::isnan(sheet.distance(Vector3(0, std::nan(""), 0))));
  // A wall larger than the box, which lies far behind it or in front of it.
  const WallSurface large = patch(1, 1, [](double u, double v) -> Vector3 { return {u - 0.5, v - 0.5, 0.06}; });
  CHECK(field_of(large).distance(Vector3::Zero()) == doctest::Approx(-6 * mm));
  CHECK(field_of(reversed(large)).distance(Vector3::Zero()) == doctest::Approx(6 * mm));
  // A tilted wall outside the box: what is behind it enters through a face away from it.
  const WallSurface tilted = patch(4, 4, [](double u, double v) -> Vector3 {
    const double along = 16 * mm * (u - 0.5);
    return {70 * mm + along, 22 * mm * (v - 0.5), 45 * mm - along};
  });
  CHECK(field_of(tilted).distance(Vector3(20 * mm, 0, -5 * mm)) == doctest::Approx(-6 * mm));
  CHECK(field_of(tilted).distance(Vector3(0, 0, 20 * mm)) == doctest::Approx(6 * mm));
}

TEST_CASE("distance field: rises to the band and stays there") {
  const DistanceField field = field_of(square(1), 0.018);
  Vector3 gradient;
  Matrix3 hessian;
  for (double z = 0.0; z < 15 * mm; z += 0.1 * mm) {
    CHECK(field.value(Vector3(mm, 0, z), gradient, hessian) < 6 * mm + 0.02 * mm);
    CHECK(field.distance(Vector3(mm, 0, -z)) == doctest::Approx(-field.distance(Vector3(mm, 0, z))).epsilon(1e-12));
    CHECK(gradient.z() > -0.02);
    CHECK(gradient.z() < 1.02);
    CHECK(hessian.norm() < 600.0);  // 1/m; the clip bends over 3 mm
    if (z < 3 * mm) CHECK_WITHIN(std::abs(field.distance(Vector3(mm, 0, z)) - z), 1e-6);
    if (z > 10.5 * mm) CHECK_WITHIN(std::abs(field.distance(Vector3(mm, 0, z)) - 6 * mm), 1e-16);
  }
}

TEST_CASE("distance field: beyond the edge of an open plane there is free space, continuously") {
  // The quarter plate x < 5 mm, z < 0.
  const WallSurface wall = patch(6, 6, [](double u, double v) -> Vector3 {
    return {5 * mm + 80 * mm * (u - 1.0), 80 * mm * (v - 0.5), 0.0};
  });
  const DistanceField field = field_of(wall);
  const auto exact = [](const Vector3& x) {
    const double side = x.x() - 5 * mm;
    if (side > 0.0 && x.z() > 0.0) return std::hypot(side, x.z());
    return std::max(side, x.z());
  };
  // Rounded where it has a kink: along the edge itself and on the diagonal inside.
  CHECK_WITHIN(worst(field, exact, 4 * mm), 0.25 * mm);
  CHECK_WITHIN(worst(
                   field, [&](const Vector3& x) { return x.z() > 2 * mm ? exact(x) : 1.0; }, 4 * mm),
               0.03 * mm);
  CHECK_WITHIN(steepest(field), 1.1);
}

TEST_CASE("distance field: continuous across curtains of curved, concave, holed and rolled sheets") {
  const auto steep = [](const WallSurface& wall) {
    const DistanceField field = field_of(wall, 0.022);
    const double result = steepest(field);
    CHECK(result > 0.9);
    return result;
  };
  const WallSurface disc = patch(5, 40, [](double u, double v) -> Vector3 {
    const double a = 2 * std::numbers::pi * v, r = 2 * mm + 8 * mm * u;
    return {r * std::cos(a), r * std::sin(a), 0.0};
  });  // with a hole of 2 mm
  CHECK_WITHIN(steep(disc), 1.3);
  WallSurface notched = square(8);
  std::erase_if(notched.triangles, [&](const Triangle& t) {
    const Vector3& v = notched.vertices[static_cast<std::size_t>(t[0])];
    return v.x() > -1 * mm && std::abs(v.y() + 1 * mm) < 5 * mm;
  });
  CHECK(notched.triangles.size() < 120);
  CHECK_WITHIN(steep(notched), 1.3);
  // Bent around a finger, normals inwards and outwards: curtains converge or cross.
  const WallSurface bent = patch(30, 12, [](double u, double v) -> Vector3 {
    const double a = 4.5 * u, r = 5 * mm + 2 * mm * std::sin(6 * v);
    return {r * std::cos(a), 24 * mm * (v - 0.5), r * std::sin(a)};
  });
  CHECK_WITHIN(steep(bent), 1.3);
  CHECK_WITHIN(steep(reversed(bent)), 1.3);
  // A spiral: the front of one turn faces the back of the next.
  const WallSurface rolled = patch(60, 6, [](double u, double v) -> Vector3 {
    const double a = 14.0 * u, r = 4 * mm + 0.7 * mm * a;
    return {r * std::cos(a), 30 * mm * (v - 0.5), r * std::sin(a)};
  });
  CHECK_WITHIN(steep(rolled), 1.35);
  // Faces turned round along a seam.
  WallSurface seam = square(6);
  for (std::size_t t = 0; t < 36; ++t) std::swap(seam.triangles[t][0], seam.triangles[t][1]);
  CHECK_WITHIN(steep(seam), 1.3);
}

TEST_CASE("distance field: exact in front of curved open sheets, free beside them") {
  const WallSurface bent = patch(60, 12, [](double u, double v) -> Vector3 {
    const double a = 2.5 * u;
    return {12 * mm * std::cos(a), 24 * mm * (v - 0.5), 12 * mm * std::sin(a)};
  });
  for (const WallSurface& wall : {bent, reversed(bent)}) {
    const DistanceField field = field_of(wall);
    const NearestFeature nearest(wall);
    Random random(16);
    int front = 0, beside = 0;
    for (int k = 0; k < 20000; ++k) {
      const Vector3 x = random_point(random, 0.018);
      const Nearest q = nearest(x);
      if (q.kind == FeatureKind::interior && q.distance > 1 * mm && q.distance < 4 * mm) {
        CHECK_WITHIN(std::abs(field.distance(x) - q.distance), 0.06 * mm);  // facets of 0.5 mm; rounded at rims
        ++front;
      }
      if (q.kind == FeatureKind::rim && q.distance > 3 * mm) {
        // Less than 0 where curtains converge; far from the wall they are known to half a brick of 4 mm.
        CHECK(field.distance(x) > (q.distance < 7 * mm ? -0.5 : -2.0) * mm);
        ++beside;
      }
    }
    CHECK(front > 300);
    CHECK(beside > 300);
  }
}

TEST_CASE("distance field: far behind a bent open wall the plate goes on, without jumps") {
  // A quarter of a cylinder of 30 mm seen from inside; its curtains are planes through the axis and across it.
  const WallSurface wall = patch(60, 1, [](double u, double v) -> Vector3 {
    const double a = 0.5 * std::numbers::pi * (0.5 + u);
    return {30 * mm * std::cos(a), 24 * mm * (v - 0.5), 30 * mm * (std::sin(a) - 1.0)};
  });
  const DistanceField field = field_of(wall, 0.025);
  const auto exact = [](const Vector3& x) {
    const Vector3 from(x.x(), 0.0, x.z() + 30 * mm);
    const double depth = from.norm() - 30 * mm;
    const double past_side = from.norm() * std::sin(std::abs(std::atan2(from.x(), from.z())) - std::numbers::pi / 4);
    const double past_end = std::abs(x.y()) - 12 * mm;
    // Away from where two of them meet.
    if (depth < 2 * mm || std::max(past_side, past_end) > 0.0) return 1.0;
    return std::max({-depth, past_side, past_end});
  };
  CHECK_WITHIN(worst(field, exact, 5 * mm, 0.022), 0.8 * mm);  // straight across curtains: half a brick is 2 mm
  CHECK_WITHIN(steepest(field, 0.022), 1.3);
  // Seen from outside, where the curtains converge.
  CHECK_WITHIN(steepest(field_of(reversed(wall), 0.025), 0.022), 1.3);
}

TEST_CASE("distance field: the order of vertices and triangles and the number of threads change no bit") {
  Random random(17);
  const WallSurface surface = patch(9, 11, [&](double u, double v) -> Vector3 {
    return {30 * mm * (u - 0.5), 30 * mm * (v - 0.5), 4 * mm * std::sin(7 * u) * std::cos(5 * v) + random(0, mm)};
  });
  const DistanceField field = field_of(surface);
  const DistanceField others[] = {field_of(shuffled(surface, 1)), field_of(shuffled(surface, 2)),
                                  field_of(surface, 0.025, mm, 2), field_of(surface, 0.025, mm, 5)};
  for (int k = 0; k < 3000; ++k) {
    const Vector3 x = random_point(random, 0.024);
    for (const DistanceField& other : others) CHECK(other.distance(x) == field.distance(x));
  }
  for (const DistanceField& other : others) CHECK(other.geometric_error() == field.geometric_error());
  CHECK(field.geometric_error() > 1e-5);
}

TEST_CASE("distance field: a mirrored wall has the mirrored field") {
  const WallSurface wall = patch(9, 11, [&](double u, double v) -> Vector3 {
    return {30 * mm * (u - 0.5), 24 * mm * v - 2 * mm, 4 * mm * std::sin(7 * u) * std::cos(5 * v)};
  });
  WallSurface image = reversed(wall);
  for (Vector3& v : image.vertices) v.y() = -v.y();
  const DistanceField field = field_of(wall), mirrored = field_of(image);
  const NearestFeature nearest(wall);
  int inner = 0;
  Random random(18);
  for (int k = 0; k < 3000; ++k) {
    const Vector3 x = random_point(random, 0.022);
    const double difference = std::abs(field.distance(x) - mirrored.distance(Vector3(x.x(), -x.y(), x.z())));
    CHECK_WITHIN(difference, 1e-5);  // beside curtains: the way of vector propagation
    const Nearest q = nearest(x);
    if (q.kind != FeatureKind::interior || q.distance < -2 * mm || nearest.nearest_end(x).squared < 25 * mm * mm)
      continue;
    CHECK_WITHIN(difference, 1e-15);
    ++inner;
  }
  CHECK(inner > 100);
}

TEST_CASE("distance field: edges are rounded by less than a third of the spacing, curvature stays bounded") {
  const WallSurface wall = box(Vector3(20, 20, 20) * mm);
  for (const double spacing : {0.8 * mm, mm, 1.25 * mm}) {
    const DistanceField field = field_of(wall, 0.016, spacing);
    Random random(19);
    double edge = 0.0, flat = 0.0, curvature = 0.0;
    // Twelve edges: 95 % of what lies within 2 mm of them; the rest of the faces is flat.
    CHECK(field.edge_rounding() > 0.05 * spacing);
    CHECK_WITHIN(field.edge_rounding() / spacing, 0.2);
    CHECK_WITHIN(field.geometric_error(), 1e-5);
    for (int k = 0; k < 2000; ++k) {
      Vector3 gradient;
      Matrix3 hessian;
      edge = std::max(edge, std::abs(field.distance(Vector3(10 * mm, 10 * mm, random(-7 * mm, 7 * mm)))));
      flat =
          std::max(flat, std::abs(field.distance(Vector3(random(-7 * mm, 7 * mm), random(-7 * mm, 7 * mm), 10 * mm))));
      field.value(random_point(random, 0.014), gradient, hessian);
      curvature = std::max(curvature, hessian.norm());
    }
    CHECK_WITHIN(edge / spacing, 0.33);
    CHECK(edge / spacing > 0.05);
    CHECK_WITHIN(flat, 1e-5);
    CHECK_WITHIN(curvature * spacing, 2.5);
  }
}

TEST_CASE("distance field: refusals") {
  const auto message = [](auto&& change) -> std::string {
    DistanceFieldOptions options{mm, 6 * mm, Vector3::Constant(-0.01), Vector3::Constant(0.01), 1};
    change(options);
    try {
      const DistanceField field(square(2), options);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  using Options = DistanceFieldOptions;
  CHECK(message([](Options&) {}) == "accepted");
  CHECK(message([](Options& o) { o.spacing = 0.0; }).find("spacing must be positive") != std::string::npos);
  CHECK(message([](Options& o) { o.band = std::nan(""); }).find("band must be positive and finite") !=
        std::string::npos);
  CHECK(message([](Options& o) { o.band = 3 * mm; }).find("at least 4 spacings") != std::string::npos);
  CHECK(message([](Options& o) { o.high.y() = -0.01; }).find("low below high") != std::string::npos);
  CHECK(message([](Options& o) { o.low.y() = -std::nan(""); }).find("finite corners") != std::string::npos);
  CHECK(message([](Options& o) { o.high.setConstant(1.0); }).find("larger spacing") != std::string::npos);
  CHECK(message([](Options& o) { o.threads = 0; }).find("threads must be at least 1") != std::string::npos);
}

}  // namespace glossa::test
