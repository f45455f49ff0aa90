#include "scene/simulation.hpp"

#include <algorithm>

#include "movements.hpp"

namespace glossa::test {
namespace {

CommandTable ramp() {
  return {{0.0, 0.02}, {1.0, 1.0, 1.0, 0.75, 0.8, 0.85}, 3};
}

/// Commands without a corner inside the movement: a two-step method needs a smooth past.
CommandTable long_ramp() {
  return {{0.0, 1.0}, {1.0, 1.0, 1.0, 0.2, 0.3, 0.4}, 3};
}

NodeField positions_at(double end, Solver& solver, const CommandTable& commands, const SimulationOptions& options) {
  Simulation simulation = started(solver, commands, options);
  REQUIRE(simulation.advance(end, nullptr) == Status::converged);
  CHECK(simulation.report().rescued == 0);
  return simulation.state().positions;
}

/// Observed order in the positions at `end`, from steps h and h / 2 against steps h / 32 of SDIRK2.
double order(Solver& solver, const CommandTable& commands, Integrator integrator, double h, double end) {
  const auto result = [&](double step) { return positions_at(end, solver, commands, accurate(step, integrator)); };
  const NodeField reference = positions_at(end, solver, commands, accurate(h / 32.0));
  const double coarse = distance(result(h), reference), fine = distance(result(h / 2.0), reference);
  REQUIRE(distance(reference, solver.scene().mesh().nodes()) > 1e-5);
  REQUIRE(fine > 1e-9);
  return std::log2(coarse / fine);
}

}  // namespace

TEST_CASE("simulation: a free body falls with v = g t and u = g t^2 / 2") {
  const HexMesh mesh = block(2, 2, 2, 0.1);
  SceneOptions options = passive(mesh, 2, 2);
  options.free.assign(options.free.size(), 1);
  options.damping.alpha = 0.0;
  Solver solver(Scene(mesh, options));
  for (const Integrator integrator : {Integrator::sdirk2, Integrator::bdf2, Integrator::trapezoidal}) {
    Simulation simulation = started(solver, no_commands(), accurate(2e-3, integrator));
    REQUIRE(simulation.advance(0.05, nullptr) == Status::converged);
    double velocity = 0.0, position = 0.0;
    for (Index n = 0; n < mesh.node_count(); ++n) {
      velocity = std::max(velocity, (at(simulation.state().velocities, n) - 0.05 * *options.gravity).norm());
      position = std::max(
          position, (at(simulation.state().positions, n) - at(mesh.nodes(), n) - 0.00125 * *options.gravity).norm());
    }
    // Tolerance of the stages, 1e-12 N (1 + beta / h), over shear stiffnesses of 100 N/m: 2e-13 m, in 0.6 ms.
    CHECK_WITHIN(velocity / 0.4905, 2e-10);
    CHECK_WITHIN(position / 0.0122625, 5e-11);
  }
}

TEST_CASE("simulation: a released damped block never gains energy, and comes to its equilibrium") {
  const HexMesh mesh = block(2, 2, 2, 0.1);
  Solver solver(Scene(mesh, passive(mesh, 2, 2)));
  const Equilibrium rest = settle(solver);
  Simulation simulation = started(solver, no_commands(), accurate(2e-3));
  double energy = simulation.kinetic_energy() + simulation.potential_energy();
  const double first = energy;
  for (int step = 0; step < 400; ++step) {
    REQUIRE(simulation.advance(simulation.state().time + 2e-3, nullptr) == Status::converged);
    const double now = simulation.kinetic_energy() + simulation.potential_energy();
    CHECK(now <= energy + 1e-9 * std::abs(first));
    energy = now;
  }
  CHECK(energy < first - 1e-7);
  CHECK_WITHIN(distance(simulation.state().positions, rest.positions), 5e-12);
}

TEST_CASE("simulation: SDIRK2 and BDF2 are of second order, passive tissue") {
  const HexMesh mesh = block(2, 2, 2, 0.1);
  Solver solver(Scene(mesh, passive(mesh, 2, 2)));
  CHECK(order(solver, no_commands(), Integrator::sdirk2, 2e-3, 0.04) >= 1.9);
  CHECK(order(solver, no_commands(), Integrator::bdf2, 2e-3, 0.04) >= 1.9);
}

TEST_CASE("simulation: second order with delayed muscles and stiffening") {
  const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  SceneOptions options = muscular(mesh);
  options.gravity.reset();
  Solver solver(Scene(mesh, options));
  // Steps that resolve how inertia gives way to viscosity when the ramp sets in, within about half a millisecond.
  CHECK(order(solver, ramp(), Integrator::sdirk2, 2.5e-4, 0.016) >= 1.9);
  CHECK(order(solver, long_ramp(), Integrator::bdf2, 2.5e-4, 0.016) >= 1.9);  // up to the first echo
}

TEST_CASE("simulation: second order with undelayed muscles and stiffening") {
  const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  SceneOptions options = muscular(mesh);
  options.gravity.reset();
  options.reflex->delay = 0.0;
  Solver solver(Scene(mesh, options));
  CHECK(order(solver, ramp(), Integrator::sdirk2, 1e-3, 0.04) >= 1.9);
  CHECK(order(solver, long_ramp(), Integrator::bdf2, 1e-3, 0.04) >= 1.9);
}

TEST_CASE("simulation: undelayed muscles settle in the static equilibrium") {
  const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  SceneOptions options = muscular(mesh);
  options.reflex->delay = 0.0;
  Solver solver(Scene(mesh, options));
  const Equilibrium rest = settle(solver, {0.75, 0.8, 0.85});
  REQUIRE(rest.report.status == Status::converged);
  Simulation simulation = started(solver, ramp(), accurate(5e-3));
  REQUIRE(simulation.advance(1.5, nullptr) == Status::converged);
  CHECK_WITHIN(distance(simulation.state().positions, rest.positions), 1.5e-10);  // what is left of the movement
  CHECK_WITHIN(worst_entry(simulation.state().tension, rest.tension), 4e-9);
}

TEST_CASE("simulation: steps land on the corners of the commands and their echoes after one and two delays") {
  const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  Solver solver(Scene(mesh, muscular(mesh)));
  Simulation simulation = started(solver, {{0.003, 0.0201}, {1.0, 1.0, 1.0, 0.9, 0.9, 0.9}, 3});
  Recording recording;
  REQUIRE(simulation.advance(0.06, &recording) == Status::converged);
  for (const double corner : {0.003, 0.0201, 0.020, 0.0371, 0.037, 0.0541, 0.06}) {
    double nearest = 1.0;
    for (const double t : recording.times) nearest = std::min(nearest, std::abs(t - corner));
    CHECK_WITHIN(nearest, 5e-16);
  }
  const std::size_t frames = recording.times.size();
  CHECK(recording.positions.size() == frames * mesh.nodes().size());
  CHECK(recording.velocities.size() == frames * mesh.nodes().size());
  CHECK(recording.tension.size() == frames * 3);
  CHECK(simulation.report().steps == static_cast<int>(frames));
  CHECK(simulation.state().time == 0.06);
}

TEST_CASE("simulation: commands that jump after a rest give the same movement, later") {
  const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  for (const double delay : {0.017, 0.0}) {
    SceneOptions options = muscular(mesh);
    options.gravity.reset();
    options.reflex->delay = delay;
    Solver solver(Scene(mesh, options));
    Simulation at_once = started(solver, {{0.0}, {0.9, 0.8, 0.85}, 3}, accurate(2e-3));
    REQUIRE(at_once.advance(0.04, nullptr) == Status::converged);
    Simulation later =
        started(solver, {{-1.0, 0.01, 0.01}, {1.1, 1.1, 1.1, 1.1, 1.1, 1.1, 0.9, 0.8, 0.85}, 3}, accurate(2e-3));
    REQUIRE(later.advance(0.05, nullptr) == Status::converged);
    CHECK(distance(at_once.state().positions, mesh.nodes()) > 1e-4);
    // Undelayed: the same steps. Delayed: rates between midpoints reach across the jump, a difference of h^2.
    CHECK_WITHIN(distance(later.state().positions, at_once.state().positions), delay == 0.0 ? 1e-12 : 2e-5);
  }
}

TEST_CASE("simulation: adaptive steps keep the estimated error and follow the accurate movement") {
  const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  Solver solver(Scene(mesh, muscular(mesh)));
  Simulation reference = started(solver, ramp(), accurate(0.1e-3));
  REQUIRE(reference.advance(0.06, nullptr) == Status::converged);
  SimulationOptions options = accurate(10e-3);
  options.error_tolerance = 2e-6;
  Simulation adaptive = started(solver, ramp(), options);
  REQUIRE(adaptive.advance(0.06, nullptr) == Status::converged);
  CHECK(adaptive.report().error_estimate <= 1.5 * 2e-6);
  CHECK(adaptive.report().steps < 200);
  CHECK_WITHIN(distance(adaptive.state().positions, reference.state().positions), 5e-5);
}

TEST_CASE("simulation: a failed or interrupted step leaves the state untouched") {
  const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  Solver solver(Scene(mesh, muscular(mesh)));
  bool stop = false;
  SimulationOptions options = accurate(2e-3);
  options.interrupt = [&] { return stop; };
  Simulation simulation = started(solver, ramp(), options);
  REQUIRE(simulation.advance(0.03, nullptr) == Status::converged);
  const State before = simulation.state();
  stop = true;
  CHECK(simulation.advance(0.04, nullptr) == Status::interrupted);
  CHECK(content(simulation.state()) == content(before));

  options.tolerance = 1e-30;  // out of reach
  stop = false;
  Simulation hopeless = started(solver, ramp(), options);
  hopeless.set_state(before);
  CHECK(hopeless.advance(0.04, nullptr) == Status::stalled);
  CHECK(hopeless.report().rescued > 1);
  CHECK(hopeless.report().steps == 0);
  CHECK(content(hopeless.state()) == content(before));
}

TEST_CASE("simulation: a step that fails after a jump of the commands leaves the state untouched") {
  const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  Solver solver(Scene(mesh, muscular(mesh)));
  const CommandTable jump({0.0, 0.02, 0.02}, {1.0, 1.0, 1.0, 0.9, 0.9, 0.9, 0.7, 0.7, 0.7}, 3);
  SimulationOptions options = accurate(2e-3);
  Simulation simulation = started(solver, jump, options);
  REQUIRE(simulation.advance(0.02, nullptr) == Status::converged);
  const State before = simulation.state();
  options.tolerance = 1e-30;  // out of reach
  Simulation hopeless = started(solver, jump, options);
  hopeless.set_state(before);
  CHECK(hopeless.advance(0.04, nullptr) == Status::stalled);
  CHECK(content(hopeless.state()) == content(before));
}

TEST_CASE("simulation: going back to a copy of the state and repeating gives the same bits") {
  const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  for (const double delay : {0.017, 0.0})
    for (const double error_tolerance : {0.0, 2e-6}) {
      SceneOptions scene = muscular(mesh);
      scene.reflex->delay = delay;
      Solver solver(Scene(mesh, scene));
      SimulationOptions options;
      options.error_tolerance = error_tolerance;
      Simulation simulation = started(solver, ramp(), options);
      REQUIRE(simulation.advance(0.017, nullptr) == Status::converged);
      const State copy = simulation.state();
      const std::vector<double> kept = content(copy);
      REQUIRE(simulation.advance(0.04, nullptr) == Status::converged);
      const std::vector<double> onward = content(simulation.state());
      CHECK(content(copy) == kept);  // copies are independent
      simulation.set_state(copy);
      CHECK(content(simulation.state()) == kept);
      REQUIRE(simulation.advance(0.04, nullptr) == Status::converged);
      CHECK(content(simulation.state()) == onward);

      Simulation another = started(solver, ramp(), options);
      another.set_state(copy);
      REQUIRE(another.advance(0.04, nullptr) == Status::converged);
      CHECK(content(another.state()) == onward);
    }
}

TEST_CASE("simulation: another solve on the same system in between changes no bit") {
  const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  for (const double delay : {0.017, 0.0}) {
    SceneOptions scene = muscular(mesh);
    scene.reflex->delay = delay;
    Solver solver(Scene(mesh, scene));
    const auto end = [&](bool disturbed) {
      Simulation simulation = started(solver, ramp());
      REQUIRE(simulation.advance(0.021, nullptr) == Status::converged);
      if (disturbed) REQUIRE(settle(solver, {0.9, 0.85, 0.9}).report.status == Status::converged);
      REQUIRE(simulation.advance(0.04, nullptr) == Status::converged);
      return content(simulation.state());
    };
    CHECK(end(true) == end(false));
  }
}

TEST_CASE("simulation: refusals") {
  const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  Solver solver(Scene(mesh, muscular(mesh)));
  const auto refused = [&](const char* message, auto&& change) {
    SimulationOptions options;
    change(options);
    CHECK_THROWS_WITH_AS(started(solver, ramp(), options), message, InputError);
  };
  refused("time step must be positive and finite, it is 0.000000 s", [](SimulationOptions& o) { o.max_step = 0.0; });
  refused("error tolerance must be finite and not negative", [](SimulationOptions& o) { o.error_tolerance = -1.0; });
  refused("tolerance must be positive and finite", [](SimulationOptions& o) { o.tolerance = 0.0; });
  const auto system = solver.system(solver.scene().options().free, {true, true, true});
  CHECK_THROWS_WITH_AS(Simulation(system, ramp(), {}, mesh.nodes(), {}, {}, {}, silent), "start time must be finite",
                       InputError);
  NodeField inverted = mesh.nodes();
  inverted[3 * 26 + 2] = 0.0;
  CHECK_THROWS_WITH_AS(Simulation(system, ramp(), {}, inverted, {}, {}, {}, 0.0), "start: hexahedron 7 is inverted",
                       InputError);
  Simulation simulation = started(solver, ramp());
  CHECK_THROWS_WITH_AS(simulation.advance(0.0, nullptr),
                       "simulation: the end must lie after the present time 0.000000 s, it is 0.000000", InputError);
  Simulation other = started(solver, {{0.0}, {1.0, silent, silent}, 3});
  CHECK_THROWS_WITH_AS(simulation.set_state(other.state()), "state: it belongs to another scene or other muscles",
                       InputError);
}

}  // namespace glossa::test
