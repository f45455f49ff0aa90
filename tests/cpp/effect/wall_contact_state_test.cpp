// What contact remembers: advances of the walls, friction, clearances.
#include "effect/wall_contact.hpp"
#include "touching.hpp"

namespace glossa::test {
namespace {

constexpr double stiffness = 4e8;
constexpr ContactLaw law{stiffness, 5e-5, stiffness, 0.0};

/// One hexahedron of 10 mm under a roof at its top, four points of 25 mm2 on it.
struct Pressed {
  HexMesh mesh = block(1, 1, 1);
  ContactPoints points = top_points(1, 1, 1);
  WallContact::Walls walls{roof(0.01)};
  WallContact effect;

  explicit Pressed(double friction = 0.0) : effect(points, walls, {stiffness, 5e-5, stiffness, friction}) {}

  /// Force on the whole body after it has been raised into the roof by `up` and moved by `along` in x.
  Vector3 raise(double up, double along = 0.0) {
    Trial trial;
    trial.positions = mapped(mesh.nodes(), Matrix3::Identity(), Vector3(along, 0.0, up));
    NodeField force(24, 0.0);
    effect.add_force(trial, force);
    Vector3 total = Vector3::Zero();
    for (Index n = 0; n < 8; ++n) total += at(force, n);
    return total;
  }
  [[nodiscard]] double pressure(std::size_t k = 0) const {
    std::vector<double> result;
    std::vector<Vector3> drag;
    effect.tractions(result, drag);
    return result[k];
  }
  [[nodiscard]] Vector3 drag(std::size_t k = 0) const {
    std::vector<double> ignored;
    std::vector<Vector3> result;
    effect.tractions(ignored, result);
    return result[k];
  }
};

}  // namespace

TEST_CASE("wall contact: advanced walls hold the body with a closed gap, and step back when it opens") {
  Pressed p;
  p.raise(-1e-4);
  p.effect.update(2e-5);
  for (const double a : p.effect.state().advance) CHECK(a == 0.0);
  p.raise(1.5e-5);
  p.effect.update(2e-5);  // within the tolerance: nothing to correct
  for (const double a : p.effect.state().advance) CHECK(a == 0.0);
  p.raise(3e-5);
  p.effect.update(2e-5);
  for (const double a : p.effect.state().advance) CHECK_WITHIN(std::abs(a - 3e-5), 1e-16);
  CHECK_WITHIN(std::abs(p.raise(0.0).z() - 1e-4 * law.pressure(3e-5)), 1e-11);
  CHECK_WITHIN(p.effect.violation(), 1e-16);
  CHECK_WITHIN(std::abs(p.effect.energy({}) - 1e-4 * law.energy(3e-5)), 1e-16);
  CHECK_WITHIN(std::abs(p.raise(-1e-5).z() - 1e-4 * law.pressure(2e-5)), 1e-11);  // over an open gap: a violation
  CHECK_WITHIN(std::abs(p.effect.violation() - 1e-5), 1e-16);
  CHECK(p.effect.penetration() == 0.0);
  p.effect.update(2e-5);
  for (const double a : p.effect.state().advance) CHECK_WITHIN(std::abs(a - 2e-5), 1e-16);
  CHECK(p.raise(-1e-3).z() == 0.0);
  CHECK_WITHIN(std::abs(p.effect.violation() - 2e-5), 1e-16);  // that is how far the wall has advanced
  p.effect.update(2e-5);
  for (const double a : p.effect.state().advance) CHECK(a == 0.0);
  p.raise(-1e-3);
  CHECK(p.effect.violation() == 0.0);
}

TEST_CASE(
    "wall contact: bounds that follow are those of the trial itself; held ones are those of the last that followed") {
  Pressed p(0.5);
  p.effect.begin_increment(p.mesh.nodes(), {Vector3::Zero()});
  CHECK_WITHIN(std::abs(p.raise(1e-5, 1e-3).x()), 1e-15);
  p.effect.follow_bounds(true);
  CHECK_WITHIN(std::abs(p.raise(1e-5, 1e-3).x() / (0.5 * 1e-4 * law.pressure(1e-5)) - 1.0), 1e-12);
  CHECK(p.effect.bound_error() == 0.0);
  CHECK_WITHIN(std::abs(p.raise(2e-5, 1e-3).x() / (0.5 * 1e-4 * law.pressure(2e-5)) - 1.0), 1e-12);
  p.effect.follow_bounds(false);
  CHECK_WITHIN(std::abs(p.raise(1e-5, 1e-3).x() / (0.5 * 1e-4 * law.pressure(2e-5)) - 1.0), 1e-12);
  CHECK(p.effect.bound_error() > 0.5);
  p.effect.follow_bounds(true);
  CHECK(p.raise(-1e-3, 1e-3).norm() == 0.0);
}

TEST_CASE("wall contact: a state is resumed from positions and pressures") {
  for (const double up : {1e-5, -5e-6}) {  // pressed in; held over a gap by a wall that has advanced
    Pressed p(0.5), q(0.5);
    for (Pressed* one : {&p, &q}) one->effect.begin_increment(one->mesh.nodes(), {Vector3::Zero()});
    p.raise(2e-5);
    if (up < 0.0) p.effect.update(1e-6);
    p.raise(up, 1e-3);
    p.effect.update_bounds(1.0);
    const Vector3 force = p.raise(up, 1e-3);
    CHECK(force.z() > 0.1);
    std::vector<double> pressure;
    std::vector<Vector3> drag;
    p.effect.tractions(pressure, drag);
    q.effect.resume(mapped(q.mesh.nodes(), Matrix3::Identity(), Vector3(1e-3, 0.0, up)), pressure);
    CHECK_WITHIN((q.raise(up, 1e-3) - force).norm() / force.norm(), 1e-12);
    for (std::size_t k = 0; k < pressure.size(); ++k)
      CHECK_WITHIN(std::abs(q.effect.state().advance[k] - p.effect.state().advance[k]), 1e-17);
  }
}

TEST_CASE("wall contact: repeated updates close the gap under a load") {
  Pressed p;
  double up = 0.0;
  int updates = 0;
  for (; updates < 60; ++updates) {
    // A load of 3 N against the four points: the depth that carries it, by bisection.
    double low = -1e-4, high = 1e-4;
    for (int k = 0; k < 70; ++k) {
      up = 0.5 * (low + high);
      (p.raise(up).z() < 3.0 ? low : high) = up;
    }
    if (p.effect.violation() <= 1e-9) break;
    p.effect.update(0.0);
  }
  CHECK(updates >= 1);
  CHECK(updates < 5);
  CHECK_WITHIN(std::abs(up), 1e-9);
  CHECK_WITHIN(std::abs(p.pressure() / 3e4 - 1.0), 1e-9);
}

TEST_CASE("wall contact: friction bounds follow the pressures by the share asked for") {
  Pressed p(0.5);
  p.raise(2e-5);
  CHECK(p.effect.bound_error() == 1.0);
  p.effect.update_bounds(0.5);
  p.raise(2e-5);
  CHECK_WITHIN(std::abs(p.effect.bound_error() - 0.5), 1e-14);
  p.effect.update_bounds(1.0);
  p.raise(2e-5);
  CHECK_WITHIN(p.effect.bound_error(), 1e-15);
  for (std::size_t k = 0; k < 4; ++k) {
    CHECK_WITHIN(std::abs(p.effect.state().pressure[k] - law.pressure(2e-5)), 1e-7);
    CHECK_WITHIN((p.effect.state().normal[k] + Vector3::UnitZ()).norm(), 1e-15);
  }
  p.raise(-1e-4);
  CHECK(p.effect.bound_error() == 1.0);  // bounds without pressure
  p.effect.update_bounds(1.0);
  p.raise(-1e-4);
  CHECK(p.effect.bound_error() == 0.0);
  CHECK(p.effect.active_count() == 0);
}

TEST_CASE("wall contact: an increment goes on from the friction of the last one, clipped to the new bound") {
  Pressed p(0.5);
  p.raise(2e-5);
  p.effect.update_bounds(1.0);
  Trial here;
  here.positions = mapped(p.mesh.nodes(), Matrix3::Identity(), Vector3(0.0, 0.0, 2e-5));
  p.effect.begin_increment(here.positions, {Vector3::Zero()});
  p.raise(2e-5, 4e-6);
  const double tension = 4e-6 * stiffness;
  CHECK_WITHIN((p.drag() - Vector3(tension, 0, 0)).norm(), 1e-8);
  p.effect.end_increment();
  here.positions = mapped(p.mesh.nodes(), Matrix3::Identity(), Vector3(4e-6, 0.0, 2e-5));
  p.effect.begin_increment(here.positions, {Vector3::Zero()});
  p.raise(2e-5, 4e-6);
  CHECK_WITHIN((p.drag() - Vector3(tension, 0, 0)).norm(), 1e-8);  // nothing has moved since
  p.raise(2e-5, 1e-6);
  CHECK_WITHIN((p.drag() - Vector3(0.25 * tension, 0, 0)).norm(), 1e-8);
  p.raise(2e-5, 1e-3);
  const double bound = 0.5 * law.pressure(2e-5);
  CHECK_WITHIN((p.drag() - Vector3(bound, 0, 0)).norm(), 1e-8);
  p.raise(2e-5, -1e-3);
  CHECK_WITHIN((p.drag() + Vector3(bound, 0, 0)).norm(), 1e-8);
  p.raise(-1e-3, -1e-3);
  p.effect.end_increment();  // lifted off
  p.effect.begin_increment(here.positions, {Vector3::Zero()});
  p.raise(2e-5, 4e-6);
  CHECK(p.drag().norm() == 0.0);
}

TEST_CASE("wall contact: without friction nothing of it is kept") {
  Pressed p;
  p.raise(2e-5);
  p.effect.begin_increment(p.mesh.nodes(), {Vector3::Zero()});
  p.effect.update_bounds(1.0);
  p.effect.end_increment();
  CHECK(p.effect.bound_error() == 0.0);
  const ContactState& state = p.effect.state();
  CHECK(state.pressure.empty());
  CHECK(state.friction.empty());
  CHECK(state.normal.empty());
  CHECK(state.slip_from.empty());
  CHECK(p.drag().norm() == 0.0);
}

TEST_CASE("wall contact: a wall moved has the effect of the body moved the other way") {
  Pressed moved, still;
  const Vector3 shift(4e-3, -3e-3, -1.25e-3);
  moved.effect.set_shift({shift});
  CHECK(moved.raise(0.0).z() > 10.0);
  CHECK_WITHIN((moved.raise(0.0) - still.raise(1.25e-3)).norm(), 1e-12);
  CHECK_WITHIN(std::abs(moved.effect.penetration() - 1.25e-3), 1e-15);
  moved.effect.set_shift({Vector3(0.0, 0.0, 1e-3)});
  CHECK(moved.raise(5e-4).z() == 0.0);
  moved.effect.set_shift({Vector3::Zero()});
  CHECK_WITHIN((moved.raise(5e-4) - still.raise(5e-4)).norm(), 1e-12);
}

TEST_CASE("wall contact: a wall that moves along drags the body by friction as the body moved back would be") {
  Pressed moved(0.5), still(0.5);
  for (Pressed* p : {&moved, &still}) {
    p->raise(2e-5);
    p->effect.update_bounds(1.0);
    p->effect.begin_increment(mapped(p->mesh.nodes(), Matrix3::Identity(), Vector3(0.0, 0.0, 2e-5)), {Vector3::Zero()});
  }
  moved.effect.set_shift({Vector3(4e-6, 0.0, 0.0)});
  const Vector3 expected = still.raise(2e-5, -4e-6);
  CHECK(expected.x() < -0.1);
  CHECK_WITHIN((moved.raise(2e-5) - expected).norm(), 1e-10);
}

TEST_CASE("wall contact: points deep behind a wall are lost, others are not") {
  Pressed p;
  p.raise(8e-3);
  CHECK_FALSE(p.effect.lost());
  p.raise(20e-3);
  CHECK(p.effect.lost());
  p.raise(1e-3);
  CHECK_FALSE(p.effect.lost());
  Trial trial;
  trial.positions = p.mesh.nodes();
  trial.positions[12] = std::numeric_limits<double>::infinity();
  NodeField force(24, 0.0);
  p.effect.add_force(trial, force);
  CHECK(p.effect.lost());
  CHECK_WITHIN(std::abs(p.raise(1e-4).z() - 1e-4 * law.pressure(1e-4)), 1e-10);  // a wild trial leaves no trace
}

TEST_CASE("wall contact: a wild first trial leaves no trace") {
  Pressed p;
  Trial trial;
  trial.positions = p.mesh.nodes();
  trial.positions[12] = std::numeric_limits<double>::infinity();
  NodeField force(24, 0.0);
  p.effect.add_force(trial, force);
  CHECK_WITHIN(std::abs(p.raise(1e-4).z() - 1e-4 * law.pressure(1e-4)), 1e-10);
  CHECK_FALSE(p.effect.lost());
}

TEST_CASE("wall contact: the deepest point is named") {
  Pressed p;
  p.points.offset = {0.0, 1e-5, -3e-5, 2e-5};
  p.raise(4e-5);
  CHECK(p.effect.deepest() == 2);
  CHECK_WITHIN(std::abs(p.effect.penetration() - 7e-5), 1e-16);
  for (std::size_t k = 0; k < 4; ++k)
    CHECK_WITHIN(std::abs(p.pressure(k) - law.pressure(4e-5 - p.points.offset[k])), 2e-7);
}

TEST_CASE("wall contact: a state put back gives the same forces") {
  Pressed p(0.5);
  p.raise(3e-5);
  p.effect.update(0.0);
  p.effect.update_bounds(1.0);
  p.effect.begin_increment(p.mesh.nodes(), {Vector3::Zero()});
  const Vector3 force = p.raise(2e-5, 1e-4);
  const ContactState kept = p.effect.state();
  p.effect.end_increment();
  p.effect.update(0.0);
  CHECK((p.raise(2e-5, 1e-4) - force).norm() > 1e-3);
  p.effect.set_state(kept);
  CHECK(p.raise(2e-5, 1e-4) == force);
  p.effect.clear();
  CHECK_WITHIN((p.raise(2e-5, 1e-4) - Vector3(0, 0, 1e-4 * law.pressure(2e-5))).norm(), 1e-11);
}

TEST_CASE("wall contact: skipping points that cannot have come near never changes a force") {
  const HexMesh mesh = block(3, 3, 2, 0.1);
  ContactPoints points = top_points(3, 3, 2, 3);
  for (std::size_t k = 0; k < points.wall.size(); ++k) points.wall[k] = static_cast<Index>(k % 3);
  for (std::size_t k = 0; k < points.offset.size(); k += 5) points.offset[k] = 5e-4;
  const WallContact::Walls walls{field_at(sphere(0.02, 60), Vector3(0.015, 0.012, 0.041)),
                                 field_at(box(Vector3(0.02, 0.014, 0.01)), Vector3(0.014, 0.017, 0.0262), 0.03, 1e-3),
                                 roof(0.021)};
  const ContactLaw rough{stiffness, 5e-5, stiffness, 0.3};
  WallContact lasting(points, walls, rough);
  Random random(261);
  NodeField positions = mesh.nodes();
  int touching = 0, skipped = 0;
  std::vector<Vector3> shift(3, Vector3::Zero());
  for (int move = 0; move < 400; ++move) {
    // Mostly small steps, at times a large one; towards the walls and back.
    const double size = move % 23 == 0 ? 2e-3 : (move % 5 == 0 ? 6e-4 : 8e-5);
    const NodeField step = random.field(positions.size(), size);
    const double rise = 8e-4 * std::sin(0.11 * move) - 2e-5;
    for (std::size_t k = 0; k < positions.size(); ++k)
      positions[k] = 0.98 * (positions[k] + step[k]) + 0.02 * mesh.nodes()[k] + (k % 3 == 2 ? rise : 0.0);
    if (move % 31 == 0)
      for (Vector3& s : shift) s = 5e-4 * random.matrix(1.0).col(0);
    lasting.set_shift(shift);
    WallContact fresh(points, walls, rough);
    fresh.set_state(lasting.state());
    fresh.set_shift(shift);
    Trial trial;
    trial.positions = positions;
    NodeField force(positions.size(), 0.0), expected(positions.size(), 0.0);
    lasting.add_force(trial, force);
    fresh.add_force(trial, expected);
    REQUIRE(force == expected);
    CHECK(lasting.lost() == fresh.lost());
    CHECK(lasting.penetration() == fresh.penetration());
    touching += lasting.active_count() > 0;
    skipped += lasting.active_count() < points.count();
    if (move % 7 == 0) lasting.update(4e-5);
    if (move % 11 == 0) {
      lasting.end_increment();
      lasting.begin_increment(positions, shift);
    }
    if (move % 50 == 49) lasting.clear();
  }
  CHECK(touching > 100);
  CHECK(touching < 400);
  CHECK(skipped > 300);
}

}  // namespace glossa::test
