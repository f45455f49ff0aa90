// A body that touches walls, in equilibrium and in time.
#include "../effect/touching.hpp"
#include "movements.hpp"

namespace glossa::test {
namespace {

constexpr double height = 0.03;

/// A block of 30 mm, its bottom held, under a roof at its top.
struct Roofed {
  HexMesh mesh = block(3, 3, 3);
  SceneOptions options;

  explicit Roofed(double friction = 0.0, Wall wall = roof(height)) {
    options.free = bottom_held(mesh, 3, 3);
    options.contact = ContactOptions{top_points(3, 3, 3), {std::move(wall)}, friction};
  }
  [[nodiscard]] static EquilibriumOptions lowered(const Vector3& shift) {
    EquilibriumOptions how;
    how.wall_start = {Vector3::Zero()};
    how.wall_shift = {shift};
    return how;
  }
  [[nodiscard]] Equilibrium posture(Solver& solver, const EquilibriumOptions& how, NodeField load = {}) const {
    System& system = *solver.system(options.free, {});
    system.set_load(std::move(load));
    return equilibrate(system, mesh.nodes(), {}, mesh.nodes(), how);
  }
  /// Force of the body on the wall (N): pressure along `up` and friction.
  [[nodiscard]] Vector3 on_wall(const std::vector<double>& pressure, const std::vector<Vector3>& drag,
                                const Vector3& up = Vector3::UnitZ()) const {
    Vector3 total = Vector3::Zero();
    for (std::size_t k = 0; k < pressure.size(); ++k)
      total += options.contact->points.area[k] * (pressure[k] * up + drag[k]);
    return total;
  }
};

Vector3 total_at(const NodeField& force, std::size_t first, std::size_t last) {
  Vector3 total = Vector3::Zero();
  for (std::size_t n = first; n < last; ++n) total += at(force, static_cast<Index>(n));
  return total;
}

}  // namespace

TEST_CASE("contact: a block pressed by a roof without friction is the block whose top is moved") {
  const Roofed body;
  Solver solver(Scene(body.mesh, body.options));
  EquilibriumOptions how = Roofed::lowered(Vector3(0, 0, -3e-3));
  how.gap_tolerance = 1e-6;
  const Equilibrium pressed = body.posture(solver, how);
  REQUIRE(pressed.report.status == Status::converged);
  CHECK_WITHIN(pressed.report.penetration, 1e-6);
  CHECK_WITHIN(pressed.report.contact_violation, 1e-6);
  CHECK_WITHIN(pressed.report.residual / pressed.report.force_scale, 1e-8);

  SceneOptions free_options = body.options;
  free_options.contact.reset();
  Solver without(Scene(body.mesh, free_options));
  FreeMask free = body.options.free;
  NodeField target = body.mesh.nodes();
  for (std::size_t n = 48; n < 64; ++n) {
    free[3 * n + 2] = 0;
    target[3 * n + 2] -= 3e-3;
  }
  const Equilibrium moved = equilibrate(*without.system(free, {}), body.mesh.nodes(), {}, target, {});
  REQUIRE(moved.report.status == Status::converged);
  CHECK_WITHIN(distance(pressed.positions, moved.positions), 3e-6);  // gap tolerance
  const double top = -total_at(moved.force, 48, 64).z();
  const Vector3 push = body.on_wall(pressed.contact_pressure, pressed.contact_drag);
  CHECK(top > 0.5);
  CHECK_WITHIN(std::abs(push.z() / top - 1.0), 1e-3);  // gap tolerance over 3 mm
  for (const Vector3& drag : pressed.contact_drag) CHECK(drag.isZero(0.0));
  // Action and reaction: the support carries what the wall feels.
  CHECK_WITHIN((total_at(pressed.force, 0, 16) - push).norm() / push.norm(), 1e-7);
}

TEST_CASE("contact: the standard tolerance is kept and reported") {
  const Roofed body;
  Solver solver(Scene(body.mesh, body.options));
  const Equilibrium pressed = body.posture(solver, Roofed::lowered(Vector3(0, 0, -1e-3)));
  REQUIRE(pressed.report.status == Status::converged);
  double deepest = 0.0;
  for (Index k = 0; k < body.options.contact->points.count(); ++k)
    deepest = std::max(deepest, body.options.contact->points.position(k, pressed.positions).z() - (height - 1e-3));
  CHECK(deepest > 0.0);
  CHECK(deepest <= 4.5e-5);
  CHECK_WITHIN(std::abs(deepest - pressed.report.penetration), 1e-16);
}

TEST_CASE("contact: friction opposes a load within Coulomb's cone, in balance with load and support") {
  const Vector3 down(0, 0, -2e-3);
  NodeField load(3 * 64, 0.0);
  for (std::size_t n = 48; n < 64; ++n) load[3 * n] = 0.01;
  std::vector<double> sway;
  for (const double friction : {0.0, 0.15, 5.0}) {
    const Roofed body(friction);
    Solver solver(Scene(body.mesh, body.options));
    const Equilibrium result = body.posture(solver, Roofed::lowered(down), load);
    REQUIRE(result.report.status == Status::converged);
    const Vector3 push = body.on_wall(result.contact_pressure, result.contact_drag);
    CHECK_WITHIN((total_at(result.force, 0, 16) + Vector3(0.16, 0, 0) - push).norm() / push.norm(), 1e-7);
    double excess = 0.0, whole = 0.0;
    for (std::size_t k = 0; k < result.contact_drag.size(); ++k) {
      excess += std::max(0.0, result.contact_drag[k].norm() - friction * result.contact_pressure[k]);
      whole += friction * result.contact_pressure[k];
      CHECK_WITHIN(std::abs(result.contact_drag[k].z()), 1e-6);
    }
    CHECK_WITHIN(excess, 0.01 * whole);
    CHECK(push.x() >= 0.0);
    CHECK((friction > 0.0) == (push.x() > 0.01));
    sway.push_back(total_at(sum(result.positions, body.mesh.nodes(), -1.0), 48, 64).x() / 16.0);
  }
  CHECK(sway[0] > 1e-3);
  CHECK(sway[1] < 0.95 * sway[0]);
  CHECK(std::abs(sway[2]) < 2e-4);  // sticks: at most the elastic slip and what it slid on the way
}

TEST_CASE("contact: a wall lowered onto a body under a load that bends it far") {
  const Roofed body;
  Solver solver(Scene(body.mesh, body.options));
  NodeField load(3 * 64, 0.0);
  for (std::size_t n = 48; n < 64; ++n) load[3 * n] = 0.02;
  const Equilibrium result = body.posture(solver, Roofed::lowered(Vector3(0, 0, -2e-3)), load);
  REQUIRE(result.report.status == Status::converged);
  CHECK(result.positions[3 * 50] - body.mesh.nodes()[3 * 50] > 5e-3);
  CHECK(result.report.penetration <= 4.5e-5);
}

TEST_CASE("contact: a convex and a concave wall are pressed in to the tolerance") {
  for (const bool convex : {true, false}) {
    const double radius = convex ? 0.012 : 0.035;
    const Vector3 centre(0.015, 0.015, convex ? height + radius : height + 4e-3 - radius);
    const WallSurface shell = sphere(radius, 100);
    const Roofed body(0.1, field_at(convex ? shell : reversed(shell), centre, 0.05));
    Solver solver(Scene(body.mesh, body.options));
    const Equilibrium result = body.posture(solver, Roofed::lowered(Vector3(1e-3, -5e-4, convex ? -3e-3 : -5e-3)));
    CAPTURE(convex);
    REQUIRE(result.report.status == Status::converged);
    CHECK(result.report.penetration <= 4.5e-5);
    CHECK_WITHIN(result.report.residual / result.report.force_scale, 1e-8);
    double pressed = 0.0;
    for (const double p : result.contact_pressure) {
      CHECK(p >= 0.0);
      pressed += p > 0.0;
    }
    CHECK(pressed > 3);
    CHECK(pressed < 36);
    CHECK(total_at(result.force, 0, 16).z() > 0.05);
  }
}

TEST_CASE("contact: a start from the posture itself stays there, at once with the pressures of its contact") {
  for (const double friction : {0.0, 0.2})
    for (const double gap_tolerance : {4.5e-5, 1e-7}) {  // without and with multipliers
      CAPTURE(friction);
      CAPTURE(gap_tolerance);
      const Roofed body(friction);
      Solver solver(Scene(body.mesh, body.options));
      System& system = *solver.system(body.options.free, {});
      EquilibriumOptions how = Roofed::lowered(Vector3(5e-4, 0, -2e-3));
      how.gap_tolerance = gap_tolerance;
      const Equilibrium first = body.posture(solver, how);
      REQUIRE(first.report.status == Status::converged);
      CHECK((first.report.contact_updates > 0) == (gap_tolerance < 4.5e-5));
      how.wall_start = how.wall_shift;
      const Equilibrium without = equilibrate(system, first.positions, first.pressure, body.mesh.nodes(), how);
      REQUIRE(without.report.status == Status::converged);
      const bool has_state = friction > 0.0 || gap_tolerance < 4.5e-5;
      CHECK((without.report.iterations + without.report.quasi_newton > 0) == has_state);
      CHECK_WITHIN(distance(without.positions, first.positions), gap_tolerance < 4.5e-5 ? 3e-7 : 1e-9);
      how.contact_start = first.contact_pressure;
      const Equilibrium again = equilibrate(system, first.positions, first.pressure, body.mesh.nodes(), how);
      REQUIRE(again.report.status == Status::converged);
      CHECK(again.report.iterations + again.report.quasi_newton == 0);
      CHECK(again.report.factorisations == 0);
      CHECK(again.positions == first.positions);
      double drag = 0.0, change = 0.0;
      for (std::size_t k = 0; k < first.contact_drag.size(); ++k) {
        drag = std::max(drag, first.contact_drag[k].norm());
        change = std::max(change, (again.contact_drag[k] - first.contact_drag[k]).norm());
      }
      CHECK((drag > 10.0) == (friction > 0.0));
      CHECK_WITHIN(change, 1e-6);
    }
}

TEST_CASE("contact: friction is bound by the very pressures of the posture") {
  const Roofed body(0.15);
  Solver solver(Scene(body.mesh, body.options));
  NodeField load(3 * 64, 0.0);
  for (std::size_t n = 48; n < 64; ++n) load[3 * n] = 0.01;
  const Equilibrium result = body.posture(solver, Roofed::lowered(Vector3(0, 0, -2e-3)), load);
  REQUIRE(result.report.status == Status::converged);
  int sliding = 0;
  for (std::size_t k = 0; k < result.contact_drag.size(); ++k) {
    const double size = result.contact_drag[k].norm(), bound = 0.15 * result.contact_pressure[k];
    CHECK(size <= bound * (1.0 + 1e-12));
    sliding += bound > 0.0 && size > bound * (1.0 - 1e-12);
  }
  CHECK(sliding > 5);
}

TEST_CASE("contact: failures end with a status") {
  const Roofed body;
  Solver solver(Scene(body.mesh, body.options));
  EquilibriumOptions deep = Roofed::lowered(Vector3(0, 0, -0.02));
  deep.wall_start = deep.wall_shift;
  CHECK(body.posture(solver, deep).report.status == Status::penetrated);
  EquilibriumOptions no_update = Roofed::lowered(Vector3(0, 0, -3e-3));
  no_update.max_contact_updates = 0;
  no_update.gap_tolerance = 1e-7;
  CHECK(body.posture(solver, no_update).report.status == Status::iteration_limit);
  const char* message = "equilibrium: one displacement per wall is needed";
  CHECK_THROWS_WITH_AS(body.posture(solver, {}), message, InputError);
  EquilibriumOptions short_start = Roofed::lowered(Vector3::Zero());
  short_start.contact_start.assign(3, 1.0);
  message = "equilibrium: one contact pressure per contact point is needed";
  CHECK_THROWS_WITH_AS(body.posture(solver, short_start), message, InputError);
}

TEST_CASE("contact: walls far away change nothing") {
  Roofed body;
  body.options.gravity = Vector3(0, 0, -9.81);
  SceneOptions without = body.options;
  without.contact.reset();
  body.options.contact->walls = {roof(height + 4e-3)};
  Solver touched(Scene(body.mesh, body.options)), free(Scene(body.mesh, without));
  const Equilibrium with = body.posture(touched, Roofed::lowered(Vector3::Zero()));
  const Equilibrium alone = settle(free);
  CHECK_WITHIN(distance(with.positions, alone.positions), 1e-12);  // tolerance over the softest mode
  for (const double p : with.contact_pressure) CHECK(p == 0.0);
}

TEST_CASE("contact: a body thrown against a wall comes to rest on it with its weight") {
  // Nothing is held: gravity pulls up and sideways, friction holds.
  Roofed body(0.5);
  body.mesh = block(3, 3, 2);
  body.options.free.clear();
  body.options.contact->points = top_points(3, 3, 2);
  body.options.contact->walls = {roof(0.0203)};
  body.options.gravity = Vector3(1.5, 0.0, 9.81);
  body.options.damping = {40.0, 0.01};
  Solver solver(Scene(body.mesh, body.options));
  Simulation simulation = started(solver, no_commands(), accurate(2e-3));
  REQUIRE(simulation.advance(0.4, nullptr) == Status::converged);
  const State& s = simulation.state();
  const Vector3 weight = 1040.0 * volume_of(body.mesh) * *body.options.gravity;
  const Vector3 push = body.on_wall(s.contact_pressure, s.contact_drag);
  CHECK_WITHIN((push - weight).norm() / weight.norm(), 3e-9);  // what is left of the movement
  CHECK_WITHIN(as_vector(s.velocities).cwiseAbs().maxCoeff(), 1e-9);
  CHECK(simulation.report().penetration <= 4.5e-5);
  CHECK(simulation.report().penetration > 0.0);
}

TEST_CASE("contact: a movement onto a wall settles in the static equilibrium") {
  Roofed body;
  body.options.contact->walls = {roof(height + 1e-4)};
  body.options.gravity = Vector3(0.0, 0.0, 30.0);
  Solver solver(Scene(body.mesh, body.options));
  const Equilibrium rest = body.posture(solver, Roofed::lowered(Vector3::Zero()));
  REQUIRE(rest.report.status == Status::converged);
  REQUIRE(*std::max_element(rest.contact_pressure.begin(), rest.contact_pressure.end()) > 100.0);
  Simulation simulation = started(solver, no_commands(), accurate(4e-3));
  REQUIRE(simulation.advance(1.0, nullptr) == Status::converged);
  CHECK_WITHIN(distance(simulation.state().positions, rest.positions), 1e-9);  // what is left of the movement
  double deepest = 0.0;
  for (Index k = 0; k < body.options.contact->points.count(); ++k)
    deepest =
        std::max(deepest, body.options.contact->points.position(k, simulation.state().positions).z() - height - 1e-4);
  CHECK(deepest > 0.0);
  CHECK(deepest <= 4.5e-5);
}

TEST_CASE("contact: a movement with a wall displaced starts from the posture with that wall and stays there") {
  const Roofed body(0.3);
  Solver solver(Scene(body.mesh, body.options));
  const EquilibriumOptions how = Roofed::lowered(Vector3(5e-4, 0, -2e-3));
  const Equilibrium rest = body.posture(solver, how);
  REQUIRE(rest.report.status == Status::converged);
  double drag = 0.0;
  for (const Vector3& d : rest.contact_drag) drag = std::max(drag, d.norm());
  REQUIRE(drag > 10.0);
  SimulationOptions options = accurate(2e-3);
  const auto from_rest = [&] {
    return Simulation(solver.system(body.options.free, {}), no_commands(), options, rest.positions, rest.pressure,
                      rest.contact_pressure, rest.contact_drag, 0.0);
  };
  CHECK_THROWS_WITH_AS((options.wall_shift = {Vector3::Zero(), Vector3::Zero()}, from_rest()),
                       "start: one displacement per wall is needed", InputError);
  options.wall_shift = how.wall_shift;
  Simulation simulation = from_rest();
  REQUIRE(simulation.advance(0.1, nullptr) == Status::converged);
  CHECK_WITHIN(distance(simulation.state().positions, rest.positions), 5e-5);  // gap tolerance
  const Vector3 push = body.on_wall(rest.contact_pressure, rest.contact_drag);
  const Vector3 later = body.on_wall(simulation.state().contact_pressure, simulation.state().contact_drag);
  CHECK_WITHIN((later - push).norm() / push.norm(), 0.03);
}

TEST_CASE("contact: going back to a copy of the state replays a movement with contact bit by bit") {
  Roofed body(0.3);
  body.options.contact->walls = {roof(height + 1e-4)};
  body.options.gravity = Vector3(12.0, 0.0, 30.0);
  Solver solver(Scene(body.mesh, body.options));
  for (const Integrator integrator : {Integrator::sdirk2, Integrator::bdf2}) {
    SimulationOptions options;
    options.integrator = integrator;
    Simulation simulation = started(solver, no_commands(), options);
    REQUIRE(simulation.advance(0.03, nullptr) == Status::converged);
    const State copy = simulation.state();
    REQUIRE(*std::max_element(copy.contact_pressure.begin(), copy.contact_pressure.end()) > 10.0);
    double drag = 0.0;
    for (const Vector3& d : copy.contact_drag) drag = std::max(drag, d.norm());
    CHECK(drag > 1.0);
    const std::vector<double> kept = content(copy);
    REQUIRE(simulation.advance(0.06, nullptr) == Status::converged);
    const std::vector<double> onward = content(simulation.state());
    CHECK(content(copy) == kept);
    simulation.set_state(copy);
    CHECK(content(simulation.state()) == kept);
    REQUIRE(simulation.advance(0.06, nullptr) == Status::converged);
    CHECK(content(simulation.state()) == onward);
    // Another simulation, and another solve on the same system in between.
    Simulation another = started(solver, no_commands(), options);
    another.set_state(copy);
    REQUIRE(body.posture(solver, Roofed::lowered(Vector3(0, 0, -1e-3))).report.status == Status::converged);
    REQUIRE(another.advance(0.06, nullptr) == Status::converged);
    CHECK(content(another.state()) == onward);
  }
}

TEST_CASE("contact: recordings hold pressure and drag of every frame") {
  Roofed body(0.3);
  body.options.contact->walls = {roof(height + 1e-4)};
  body.options.gravity = Vector3(12.0, 0.0, 30.0);
  Solver solver(Scene(body.mesh, body.options));
  Simulation simulation = started(solver, no_commands());
  Recording recording;
  REQUIRE(simulation.advance(0.03, &recording) == Status::converged);
  const std::size_t frames = recording.times.size();
  REQUIRE(recording.contact_pressure.size() == frames * 36);
  REQUIRE(recording.contact_drag.size() == 3 * frames * 36);
  const State& s = simulation.state();
  for (std::size_t k = 0; k < 36; ++k) {
    CHECK(recording.contact_pressure[36 * (frames - 1) + k] == s.contact_pressure[k]);
    for (std::size_t i = 0; i < 3; ++i)
      CHECK(recording.contact_drag[3 * (36 * (frames - 1) + k) + i] == s.contact_drag[k](static_cast<Eigen::Index>(i)));
  }
  CHECK(recording.contact_pressure.front() == 0.0);
}

TEST_CASE("contact: a movement refuses what it cannot start from") {
  const Roofed body(0.3);
  Solver solver(Scene(body.mesh, body.options));
  const auto system = solver.system(body.options.free, {});
  const auto start = [&](const NodeField& positions, const std::vector<double>& pressure,
                         const std::vector<Vector3>& drag) {
    return Simulation(system, no_commands(), {}, positions, {}, pressure, drag, 0.0);
  };
  const char* message = "start: one pressure and one drag per contact point are needed";
  CHECK_THROWS_WITH_AS(start(body.mesh.nodes(), {1.0, 2.0}, {}), message, InputError);
  CHECK_THROWS_WITH_AS(start(body.mesh.nodes(), {}, {Vector3::Zero()}), message, InputError);
  const NodeField deep = mapped(body.mesh.nodes(), Matrix3::Identity(), Vector3(0, 0, 0.02));
  CHECK_THROWS_WITH_AS(start(deep, {}, {}), "start: the body lies deep behind a wall", InputError);
}

}  // namespace glossa::test
