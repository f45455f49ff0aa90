// Forces, energies and tangents of contact; what it remembers is in wall_contact_state_test.cpp.
#include "effect/wall_contact.hpp"

#include <Eigen/Eigenvalues>

#include "touching.hpp"

namespace glossa::test {
namespace {

constexpr double radius = 0.02, stiffness = 4e8;

Wall ball() {
  static const Wall wall = field_at(sphere(radius, 60), Vector3(0.012, 0.009, 0.0385));
  return wall;
}

/// The same sphere touched from inside, its lowest point at 21 mm.
Wall bowl() {
  static const Wall wall = field_at(reversed(sphere(radius, 60)), Vector3(0.01, 0.01, 0.001));
  return wall;
}

/// Top of block(2, 2, 2) at a ball or bowl and a second wall, by offsets at gaps of -40 to 30 um; some points as in a
/// mirrored half.
struct Touching {
  HexMesh mesh = block(2, 2, 2, 0.1);
  ContactPoints points = top_points(2, 2, 2, 3);
  WallContact::Walls walls;
  std::unique_ptr<WallContact> effect;
  Trial trial;

  explicit Touching(double friction, Wall first = ball(), bool mirrored = false)
      : walls{std::move(first), roof(0.0195)} {
    Random random(251);
    for (std::size_t k = 0; k < points.wall.size(); k += 4) points.wall[k] = 1;
    if (mirrored)
      for (PointWeight& w : points.weights.values) w.across = random(-1.0, 1.0) * w.along;
    effect = std::make_unique<WallContact>(points, walls, ContactLaw{stiffness, 5e-5, 0.1 * stiffness, friction});
    trial.positions = sum(mesh.nodes(), random.field(mesh.nodes().size(), 3e-4));
    for (Index k = 0; k < points.count(); ++k) {
      const auto i = static_cast<std::size_t>(k);
      points.offset[i] = random(-4e-5, 3e-5) -
                         walls[static_cast<std::size_t>(points.wall[i])]->distance(points.position(k, trial.positions));
    }
    ContactState state = effect->state();
    for (double& a : state.advance) a = std::max(0.0, random(-1e-5, 2e-5));
    effect->set_state(std::move(state));
  }
  Vector force(const NodeField& positions) {
    Trial moved;
    moved.positions = positions;
    NodeField result(positions.size(), 0.0);
    effect->add_force(moved, result);
    return as_vector(result);
  }
  double energy(const NodeField& positions) {
    force(positions);
    return effect->energy(trial);
  }
  [[nodiscard]] NodeField moved(Eigen::Index component, double h) const {
    NodeField result = trial.positions;
    result[static_cast<std::size_t>(component)] += h;
    return result;
  }
  Eigen::MatrixXd tangent() {
    force(trial.positions);
    const FreeMask free(mesh.nodes().size(), 1);
    BlockMatrix matrix(mesh.node_count(), free, mesh.hexahedra(), effect->couplings(), &natural_order);
    effect->bind(matrix);
    matrix.gather(std::vector<double>(8 * 324, 0.0), 0.0, 1);
    effect->add_tangent(trial, matrix);
    return dense(matrix.columns(1));
  }
  Eigen::MatrixXd differences() {
    Eigen::MatrixXd result(81, 81);
    for (Eigen::Index k = 0; k < 81; ++k)
      result.col(k) = derivative([&](double h) { return force(moved(k, h)); }, 1e-8);
    return result;
  }
  Vector gradient() {
    Vector result(81);
    for (Eigen::Index k = 0; k < 81; ++k) result(k) = slope([&](double h) { return energy(moved(k, h)); }, 1e-8);
    return result;
  }
  /// Friction bounds from the pressures here, and a slip of `size` (m) since the increment began. Returns how many
  /// points slide and how many stick.
  std::pair<int, int> slip(double size) {
    force(trial.positions);
    effect->update_bounds(1.0);
    const Vector3 back = size * Vector3(0.8, -0.6, 0.0);
    effect->begin_increment(trial.positions, {back, back});
    force(trial.positions);
    std::vector<double> pressure;
    std::vector<Vector3> drag;
    effect->tractions(pressure, drag);
    std::pair<int, int> count{0, 0};
    for (std::size_t k = 0; k < drag.size(); ++k) {
      const double bound = 0.3 * effect->state().pressure[k];
      if (bound == 0.0) continue;
      CHECK(drag[k].norm() <= bound * (1.0 + 1e-14));
      ++(drag[k].norm() < bound * (1.0 - 1e-12) ? count.second : count.first);
    }
    return count;
  }
};

}  // namespace

TEST_CASE("wall contact: pressure times area along the wall's normal, shared by the weights") {
  const HexMesh mesh = block(1, 1, 1);
  const ContactPoints points = top_points(1, 1, 1, 1);
  const WallContact::Walls walls{roof(0.01)};
  WallContact effect(points, walls, {stiffness, 5e-5, stiffness, 0.0});
  Trial trial;
  trial.positions = mapped(mesh.nodes(), Matrix3::Identity(), Vector3(0, 0, 2e-5));
  NodeField force(24, 0.0);
  effect.add_force(trial, force);
  const double pressure = stiffness * 2e-5 / (1.0 - 0.4);
  for (Index n = 0; n < 8; ++n) {
    const double share = n < 4 ? 0.0 : 0.25 * 1e-4 * pressure;  // the body resists upwards: downwards push
    CHECK_WITHIN((at(force, n) - Vector3(0, 0, share)).norm(), 1e-12);
  }
  CHECK(effect.active_count() == 1);
  CHECK_WITHIN(std::abs(effect.penetration() - 2e-5), 1e-17);
  CHECK_WITHIN(std::abs(effect.violation() - 2e-5), 1e-17);
  CHECK_WITHIN(std::abs(effect.energy(trial) - 1e-4 * stiffness * 25e-10 * (-std::log(0.6) - 0.4)), 1e-17);
}

TEST_CASE("wall contact: neither force nor energy nor entry where every gap is open and no wall has advanced") {
  Touching t(0.3);
  t.effect->clear();
  t.trial.positions = mapped(t.mesh.nodes(), Matrix3::Identity(), Vector3(0, 0, -4e-3));
  CHECK(t.force(t.trial.positions).isZero(0.0));
  CHECK(t.effect->active_count() == 0);
  CHECK(t.effect->energy(t.trial) == 0.0);
  CHECK(t.effect->violation() == 0.0);
  CHECK(t.effect->penetration() == 0.0);
  CHECK(t.effect->deepest() == -1);
  CHECK(t.tangent().isZero(0.0));
}

TEST_CASE("wall contact: without friction the force is the gradient of the energy, the tangent its derivative") {
  for (const bool mirrored : {false, true})
    for (const Wall& wall : {ball(), bowl()}) {
      Touching t(0.0, wall, mirrored);
      const Vector force = t.force(t.trial.positions);
      REQUIRE(t.effect->active_count() > 8);
      REQUIRE(t.effect->penetration() > 3e-5);
      CHECK_WITHIN(worst_entry(force, t.gradient()), 1e-9);  // rounding eps E / (h f)
      const Eigen::MatrixXd tangent = t.tangent(), reference = t.differences();
      CHECK_WITHIN(worst_entry(tangent, reference), 5e-9);  // rounding eps f / (h K)
      CHECK(tangent != reference);
    }
}

TEST_CASE("wall contact: the same with friction at held bounds, sticking, sliding and both") {
  for (const bool mirrored : {false, true})
    for (const double size : {1e-8, 1.5e-4, 2e-3}) {
      Touching t(0.3, ball(), mirrored);
      const auto [sliding, sticking] = t.slip(size);
      CAPTURE(size);
      CHECK((size == 1e-8 ? sticking > 12 : size == 2e-3 ? sliding > 12 : sliding > 3 && sticking > 3));
      const Vector force = t.force(t.trial.positions);
      CHECK_WITHIN(worst_entry(force, t.gradient()), 1e-9);
      CHECK_WITHIN(worst_entry(t.tangent(), t.differences()), 1e-8);  // truncation where the slip is small
    }
}

TEST_CASE("wall contact: friction resists the slip within the plane of the wall") {
  const HexMesh mesh = block(1, 1, 1);
  const ContactPoints points = top_points(1, 1, 1, 1);
  const WallContact::Walls walls{roof(0.01)};
  WallContact effect(points, walls, {stiffness, 5e-5, stiffness, 0.5});
  Trial trial;
  trial.positions = mapped(mesh.nodes(), Matrix3::Identity(), Vector3(0, 0, 2e-5));
  NodeField force(24, 0.0);
  effect.add_force(trial, force);
  effect.update_bounds(1.0);
  effect.begin_increment(trial.positions, {Vector3::Zero()});
  const auto top = [&](const Vector3& slip) {
    trial.positions = mapped(mesh.nodes(), Matrix3::Identity(), Vector3(0, 0, 2e-5) + slip);
    force.assign(24, 0.0);
    effect.add_force(trial, force);
    return Vector3(at(force, 4) + at(force, 5) + at(force, 6) + at(force, 7));
  };
  const double pressure = stiffness * 2e-5 / (1.0 - 0.4);
  CHECK_WITHIN((top(Vector3(3e-6, -4e-6, 0)) - 1e-4 * Vector3(3e-6 * stiffness, -4e-6 * stiffness, pressure)).norm(),
               1e-11);                                                                                     // sticks
  CHECK_WITHIN((top(Vector3(3e-4, -4e-4, 0)) - 1e-4 * pressure * Vector3(0.3, -0.4, 1.0)).norm(), 1e-11);  // slides
  CHECK_WITHIN((top(Vector3(0, 0, 1e-5)) - 1e-4 * Vector3(0, 0, stiffness * 3e-5 / (1.0 - 0.6))).norm(), 1e-11);
}

TEST_CASE("wall contact: the negative curvature of a convex wall can be left out, that of a concave one is positive") {
  Touching convex(0.0);
  for (std::size_t k = 0; k < convex.points.wall.size(); ++k) convex.points.wall[k] = 0;
  const auto least = [](const Eigen::MatrixXd& K) {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K).eigenvalues().minCoeff() / K.cwiseAbs().maxCoeff();
  };
  const Eigen::MatrixXd whole = convex.tangent();
  convex.effect->drop_negative_curvature(true);
  const Eigen::MatrixXd cured = convex.tangent();
  CHECK(least(whole) < -1e-4);
  CHECK_WITHIN(-least(cured), 1e-14);
  CHECK_WITHIN(-least(cured - whole), 1e-12);  // nothing positive is lost
  convex.effect->drop_negative_curvature(false);
  CHECK(convex.tangent() == whole);
}

TEST_CASE("wall contact: multiply is the assembled matrix times a field") {
  for (const bool mirrored : {false, true}) {
    Touching t(0.3, ball(), mirrored);
    t.slip(1.5e-4);
    const Eigen::MatrixXd tangent = t.tangent();
    const NodeField x = Random(253).field(81, 1.0);
    NodeField product(81, 0.0);
    t.effect->multiply(t.trial, x, product);
    CHECK_WITHIN(worst_entry(as_vector(product), (tangent * as_vector(x)).eval()), 1e-14);
  }
}

TEST_CASE("wall contact: a mirrored half feels what the half of the whole body feels") {
  const Vector3 flip(1.0, -1.0, 1.0);
  // Nodes 0 and 1 of the half; 2 and 3 are their images in the whole body.
  ContactPoints half, whole;
  half.weights.values = {{0, 0.7, 0.3}, {1, 0.3, 0.1}};
  whole.weights.values = {{0, 0.5, 0.5}, {1, 0.2, 0.2}, {2, 0.2, 0.2}, {3, 0.1, 0.1}};
  for (ContactPoints* points : {&half, &whole}) {
    points->weights.push_row();
    points->area = {2e-5};
    points->wall = {0};
    points->offset = {0.0};
  }
  const WallContact::Walls walls{ball()};
  const ContactLaw law{stiffness, 5e-5, stiffness, 0.3};
  WallContact in_half(half, walls, law), in_whole(whole, walls, law);
  const Vector3 near = Vector3(0.012, 0.009, 0.0385) + (radius - 5e-5) * Vector3(0.3, -0.2, -1.0).normalized();
  Trial trial;
  trial.positions.assign(12, 0.0);
  const auto place = [&](const Vector3& target, double tilt) {
    const Vector3 b(target.x() + tilt, 0.5 * target.y(), target.z() - tilt);
    const Vector3 rest = target - Vector3(0.3, 0.1, 0.3).cwiseProduct(b);
    const Vector3 a = rest.cwiseQuotient(Vector3(0.7, 0.3, 0.7));
    for (const auto& [n, x] :
         {std::pair{0, a}, {1, b}, {2, Vector3(flip.cwiseProduct(a))}, {3, Vector3(flip.cwiseProduct(b))}})
      Eigen::Map<Vector3>(trial.positions.data() + 3 * n) = x;
  };
  NodeField f_half, f_whole;
  const auto evaluate = [&] {
    f_half.assign(12, 0.0);
    f_whole.assign(12, 0.0);
    in_half.add_force(trial, f_half);
    in_whole.add_force(trial, f_whole);
  };
  place(near, 1e-3);
  CHECK_WITHIN((half.position(0, trial.positions) - near).norm(), 1e-16);
  CHECK_WITHIN((whole.position(0, trial.positions) - near).norm(), 1e-16);
  evaluate();
  for (WallContact* effect : {&in_half, &in_whole}) {
    effect->update_bounds(1.0);
    effect->begin_increment(trial.positions, {Vector3::Zero()});
  }
  place(near + Vector3(2e-6, -3e-6, 0.0), 1.1e-3);
  evaluate();
  for (const Index n : {0, 1}) {
    const Vector3 expected = at(f_whole, n) + flip.cwiseProduct(at(f_whole, n + 2));
    CHECK(expected.norm() > 1e-2);
    CHECK_WITHIN((at(f_half, n) - expected).norm() / expected.norm(), 1e-11);  // rounding of the gap
  }
}

TEST_CASE("wall contact: only what is in a common face or group is coupled, each group once") {
  const Touching t(0.0);
  CHECK(t.effect->couplings().size() == 4);  // 36 points in four faces
  for (Index g = 0; g < 4; ++g) CHECK(t.effect->couplings().length(g) == 4);
}

}  // namespace glossa::test
