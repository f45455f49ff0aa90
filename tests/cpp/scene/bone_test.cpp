// A bone that moves, in equilibrium and in time, against small analytic cases. The tissue is soft and light enough not
// to be felt where its stiffness is not wanted.
#include <algorithm>
#include <complex>

#include "bone/rotation.hpp"
#include "movements.hpp"

namespace glossa::test {
namespace {

constexpr double cell = 0.01, k_spring = 220.0, mass = 0.02, reach = 3.0;
constexpr Index centre = 8, turn = 9, anchor = 10;

/// A hexahedron whose bottom is held and whose top is the bone: nodes 4 .. 7, half the diagonal of the face away from
/// the centre. Anchors 10 .. 13 lie `reach` times as far out; springs without rest length, so that the bone's energy is
/// 2 k |u|^2 + k reach r^2 sum (1 - cos) for a shift u of the centre and a turn in the plane.
struct Bony {
  HexMesh mesh = anatomy();
  SceneOptions options;
  double arm = cell * std::sqrt(0.5);

  static HexMesh anatomy() {
    const HexMesh cube = block(1, 1, 1, 0.0, cell);
    NodeField nodes = cube.nodes();
    const Vector3 middle(cell / 2, cell / 2, cell);
    nodes.insert(nodes.end(), middle.data(), middle.data() + 3);
    nodes.insert(nodes.end(), 3, 0.0);
    for (const Index n : {4, 5, 6, 7}) {
      const Vector3 out = middle + reach * (at(cube.nodes(), n) - middle);
      nodes.insert(nodes.end(), out.data(), out.data() + 3);
    }
    return {std::move(nodes), cube.hexahedra()};
  }
  Bony() {
    options.free = bottom_held(mesh, 1, 1);
    options.tissue = {1e-4, 0.0, 1e-3};
    options.density = 1e-3;
    options.damping = {0.0, 0.0};
    options.bone = Bone{{{4, 5, 6, 7}, centre, turn}, {}, {}};
    for (const Index k : {0, 1, 2, 3}) {
      options.bone->masses.push_back({4 + k, mass / 4});
      options.bone->springs.push_back({4 + k, anchor + k, k_spring, 0.0});
    }
  }
  [[nodiscard]] Vector3 lever(Index node) const { return at(mesh.nodes(), node) - at(mesh.nodes(), centre); }
  /// Start of a movement: pose shifted and turned by rotation vector `theta`; tied nodes are put there by the scene.
  [[nodiscard]] Simulation released(Solver& solver, const Vector3& shift, const Vector3& theta,
                                    const SimulationOptions& how) const {
    NodeField start = mesh.nodes();
    for (std::size_t i = 0; i < 3; ++i) {
      start[3 * centre + i] += shift(static_cast<Eigen::Index>(i));
      start[3 * turn + i] = arm * theta(static_cast<Eigen::Index>(i));
    }
    return {solver.system(solver.scene().options().free, {}), no_commands(), how, start, {}, {}, {}, 0.0};
  }
};

/// Stages solved to 1e-9 N: in short steps inertia is known to 1e-10 N only.
SimulationOptions tight(double step, Integrator method) {
  SimulationOptions options = accurate(step, method);
  options.tolerance = 1e-8;
  return options;
}

/// What a method makes of y' = -i omega y with y(0) = 1 after n steps.
std::complex<double> discrete(Integrator method, double omega_h, int n) {
  const std::complex<double> z(0.0, -omega_h), g = sdirk2_gamma;
  const std::complex<double> sdirk2 = (1.0 + (1.0 - 2.0 * g) * z) / ((1.0 - g * z) * (1.0 - g * z));
  if (method == Integrator::sdirk2) return std::pow(sdirk2, n);
  if (method == Integrator::trapezoidal) return std::pow((1.0 + 0.5 * z) / (1.0 - 0.5 * z), n);
  std::complex<double> before = 1.0, now = sdirk2;  // bdf2 is started by sdirk2
  for (int k = 1; k < n; ++k) {
    const std::complex<double> next = (4.0 * now - before) / (3.0 - 2.0 * z);
    before = now;
    now = next;
  }
  return now;
}

/// Angle of a pendulum phi'' = -omega^2 sin phi released at rest, by Runge and Kutta's method in steps of 1 us.
double pendulum(double phi, double omega, double time) {
  double rate = 0.0;
  const int steps = static_cast<int>(std::lround(time / 1e-6));
  const double h = time / steps;
  const auto pull = [&](double x) { return -omega * omega * std::sin(x); };
  for (int k = 0; k < steps; ++k) {
    const double a1 = pull(phi), v2 = rate + 0.5 * h * a1, a2 = pull(phi + 0.5 * h * rate);
    const double v3 = rate + 0.5 * h * a2, a3 = pull(phi + 0.5 * h * v2);
    const double v4 = rate + h * a3, a4 = pull(phi + h * v3);
    phi += h / 6.0 * (rate + 2.0 * v2 + 2.0 * v3 + v4);
    rate += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }
  return phi;
}

}  // namespace

TEST_CASE("bone: loads and its own weight move it by force over the sum of the springs") {
  Bony body;
  body.options.gravity = Vector3(1.0, 2.0, -9.0);
  Solver solver(Scene(body.mesh, body.options));
  System& system = *solver.system(solver.scene().options().free, {});
  NodeField load(body.mesh.nodes().size(), 0.0);
  for (const std::size_t n : {4, 5, 6, 7}) load[3 * n + 1] = 0.1;
  system.set_load(load);
  const Equilibrium result = equilibrate(system, body.mesh.nodes(), {}, body.mesh.nodes(), {});
  REQUIRE(result.report.status == Status::converged);
  const Vector3 expected = (mass * *body.options.gravity + Vector3(0, 0.4, 0)) / (4.0 * k_spring);
  CHECK_WITHIN((at(result.positions, centre) - at(body.mesh.nodes(), centre) - expected).norm() / expected.norm(),
               1e-7);  // stiffness of the tissue over that of the springs
  CHECK_WITHIN(at(result.positions, turn).norm() / body.arm, 5e-9);
}

TEST_CASE("bone: a couple turns it by the angle of the analytic balance") {
  const Bony body;
  Solver solver(Scene(body.mesh, body.options));
  System& system = *solver.system(solver.scene().options().free, {});
  NodeField load(body.mesh.nodes().size(), 0.0);
  const double force = 4.0;
  for (const Index n : {4, 5, 6, 7})
    Eigen::Map<Vector3>(load.data() + 3 * n) = force * Vector3::UnitZ().cross(body.lever(n)).normalized();
  system.set_load(load);
  const Equilibrium result = equilibrate(system, body.mesh.nodes(), {}, body.mesh.nodes(), {});
  REQUIRE(result.report.status == Status::converged);
  // Moments: of the dead loads 4 F r cos phi, of the springs 4 k reach r^2 sin phi.
  const double phi = std::atan(force / (k_spring * reach * body.arm));
  CHECK(phi > 0.6);
  CHECK_WITHIN((at(result.positions, turn) / body.arm - Vector3(0, 0, phi)).norm(), 1e-8);
  CHECK_WITHIN((at(result.positions, centre) - at(body.mesh.nodes(), centre)).norm() / body.arm, 5e-8);
  const Matrix3 R = rotation_matrix(Vector3(0, 0, phi));
  for (const Index n : {4, 5, 6, 7})
    CHECK_WITHIN((at(result.positions, n) - at(body.mesh.nodes(), centre) - R * body.lever(n)).norm() / body.arm, 5e-8);
}

TEST_CASE("bone: in equilibrium with tissue the forces on it balance, moments too, and it is rigid") {
  Bony body;
  body.options.tissue = {1037.0, 486.0, 1e5};
  for (BoneSpring& spring : body.options.bone->springs) spring.rest_length = 0.01;
  Solver solver(Scene(body.mesh, body.options));
  System& system = *solver.system(solver.scene().options().free, {});
  NodeField load(body.mesh.nodes().size(), 0.0);
  const NodeField random = Random(271).field(12, 2.0);
  std::copy(random.begin(), random.end(), load.begin() + 12);
  system.set_load(load);
  const Equilibrium result = equilibrate(system, body.mesh.nodes(), {}, body.mesh.nodes(), {});
  REQUIRE(result.report.status == Status::converged);
  CHECK(at(result.positions, turn).norm() / body.arm > 0.1);
  // result.force is the sum of all effects at each node; the bone itself transmits what is left at the tied ones.
  Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
  double size = 0.0;
  for (const Index n : {4, 5, 6, 7}) {
    force += at(result.force, n);
    moment += (at(result.positions, n) - at(result.positions, centre)).cross(at(result.force, n));
    size += at(result.force, n).norm();
    for (const Index m : {4, 5, 6, 7})
      CHECK_WITHIN(std::abs((at(result.positions, n) - at(result.positions, m)).norm() -
                            (at(body.mesh.nodes(), n) - at(body.mesh.nodes(), m)).norm()),
                   1e-17);
  }
  CHECK(size > 1.0);
  CHECK_WITHIN(force.norm() / size, 2e-9);
  CHECK_WITHIN(moment.norm() / (body.arm * size), 2e-9);
  // The support of the whole, bottom and anchors, carries the loads.
  Vector3 support = Vector3::Zero(), loads = Vector3::Zero();
  for (Index n = 0; n < body.mesh.node_count(); ++n) {
    if (n < 4 || n >= anchor) support += at(result.force, n);
    loads += at(load, n);
  }
  CHECK_WITHIN((support + loads).norm() / size, 2e-9);
}

TEST_CASE("bone: a mirrored half gives the posture of the whole") {
  // The whole: block(2, 2, 1) around the plane y = 0; the bone is its face x = 20 mm. The half: y >= 0.
  const auto posture = [](bool half) {
    const Index ny = half ? 1 : 2;
    HexMesh plain = block(2, ny, 1);
    NodeField nodes = plain.nodes();
    if (!half)
      for (std::size_t n = 0; n < nodes.size() / 3; ++n) nodes[3 * n + 1] -= cell;
    const auto first = static_cast<Index>(nodes.size() / 3);
    for (const double x : {0.022, 0.0, 0.007, 0.0, 0.0, 0.0, 0.035, 0.02, -0.004, 0.035, -0.02, -0.004})
      nodes.push_back(x);
    const HexMesh mesh(std::move(nodes), plain.hexahedra());
    SceneOptions options;
    options.gravity = Vector3(4.0, 0.0, -9.81);
    options.free.assign(mesh.nodes().size(), 1);
    Bone bone{{{}, first, first + 1}, {}, {}};
    for (Index n = 0; n < first; ++n) {
      const Vector3 x = at(mesh.nodes(), n);
      if (x.x() == 0.0) std::fill_n(options.free.begin() + 3 * n, 3, std::uint8_t{0});
      if (half && x.y() == 0.0) options.free[3 * static_cast<std::size_t>(n) + 1] = 0;
      if (x.x() != 0.02) continue;
      bone.ties.nodes.push_back(n);
      if (x.y() == 0.0) continue;
      bone.masses.push_back({n, 0.004});
      bone.springs.push_back({n, x.y() > 0.0 ? first + 2 : first + 3, 100.0, 0.02});
    }
    if (half)
      for (const Index c : {3 * first + 1, 3 * first + 3, 3 * first + 5}) options.free[static_cast<std::size_t>(c)] = 0;
    options.bone = bone;
    Solver solver(Scene(mesh, options));
    EquilibriumOptions exact;
    exact.tolerance = 1e-11;
    const Equilibrium result =
        equilibrate(*solver.system(solver.scene().options().free, {}), mesh.nodes(), {}, mesh.nodes(), exact);
    REQUIRE(result.report.status == Status::converged);
    return std::pair{result.positions, first};
  };
  const auto [whole, in_whole] = posture(false);
  const auto [half, in_half] = posture(true);
  CHECK((at(half, in_half) - Vector3(0.022, 0.0, 0.007)).norm() > 1e-4);
  CHECK_WITHIN((at(half, in_half) - at(whole, in_whole)).norm(), 5e-13);  // tolerance over the softest mode
  for (const Index k : {0, 1})
    for (const Index j : {0, 1})
      for (const Index i : {0, 1, 2})
        CHECK_WITHIN((at(half, i + 3 * (j + 2 * k)) - at(whole, i + 3 * (j + 1 + 3 * k))).norm(), 5e-13);
}

TEST_CASE("bone: on springs it oscillates with sqrt(k / m), as each method makes of it") {
  Bony body;
  body.options.free.assign(body.options.free.size(), 0);
  for (std::size_t c = 3 * centre; c < 3 * anchor; ++c) body.options.free[c] = 1;
  Solver solver(Scene(body.mesh, body.options));
  const double omega = std::sqrt(4.0 * k_spring / mass), h = 1e-3;
  const Vector3 shift(1e-3, -0.5e-3, 2e-3);
  for (const Integrator method : {Integrator::sdirk2, Integrator::bdf2, Integrator::trapezoidal}) {
    Simulation simulation = body.released(solver, shift, Vector3::Zero(), accurate(h, method));
    for (int n = 1; n <= 60; ++n) {  // two periods
      REQUIRE(simulation.advance(n * h, nullptr) == Status::converged);
      const std::complex<double> expected = discrete(method, omega * h, n);
      const State& s = simulation.state();
      CHECK_WITHIN(
          (at(s.positions, centre) - at(body.mesh.nodes(), centre) - expected.real() * shift).norm() / shift.norm(),
          1e-6);  // what the tissue adds
      CHECK_WITHIN((at(s.velocities, centre) - omega * expected.imag() * shift).norm() / (omega * shift.norm()), 1e-6);
    }
    CHECK(simulation.report().steps == 60);
    CHECK(simulation.report().rescued == 0);
  }
  CHECK(std::abs(discrete(Integrator::sdirk2, omega * h, 60) - std::polar(1.0, -omega * h * 60)) < 0.2);
}

TEST_CASE("bone: point masses are its moment of inertia in a swing") {
  Bony body;
  body.options.free.assign(body.options.free.size(), 0);
  for (std::size_t c = 3 * centre; c < 3 * anchor; ++c) body.options.free[c] = 1;
  Solver solver(Scene(body.mesh, body.options));
  const double omega = std::sqrt(4.0 * k_spring * reach / mass), end = 0.006;  // I = m r^2; a third of a period
  const auto error = [&](Integrator method, double swing, double h) {
    Simulation simulation = body.released(solver, Vector3::Zero(), Vector3(0, 0, swing), tight(h, method));
    REQUIRE(simulation.advance(end, nullptr) == Status::converged);
    CHECK(simulation.report().rescued == 0);
    const Vector3 theta = at(simulation.state().positions, turn) / body.arm;
    CHECK_WITHIN(theta.head(2).norm(), 1e-15);
    return std::abs(theta.z() - pendulum(swing, omega, end)) / swing;
  };
  const auto order = [&](Integrator method, double swing) {
    const double coarse = error(method, swing, 0.25e-3), fine = error(method, swing, 0.125e-3);
    REQUIRE(fine > 1e-5);
    CHECK(fine < 4e-3);
    return std::log2(coarse / fine);
  };
  CHECK(order(Integrator::bdf2, 1.0) > 1.9);
  CHECK(order(Integrator::trapezoidal, 1.0) > 1.9);
  CHECK(order(Integrator::sdirk2, 0.01) > 1.9);
  // Its first stage knows velocities to first order only, and those of tied nodes leave the rigid motion: in turns
  // larger than a bone makes in speech it is of first order.
  CHECK(error(Integrator::sdirk2, 0.3, 0.5e-3) < 0.01);
}

TEST_CASE("bone: undamped tumbling keeps its energy to second order, and stays rigid") {
  Bony body;
  body.options.free.assign(body.options.free.size(), 0);
  for (std::size_t c = 3 * centre; c < 3 * anchor; ++c) body.options.free[c] = 1;
  for (std::size_t k = 0; k < 4; ++k) {
    body.options.bone->masses[k].mass *= 0.5 + 0.4 * static_cast<double>(k);
    body.options.bone->springs[k].stiffness *= 1.5 - 0.3 * static_cast<double>(k);
    body.options.bone->springs[k].rest_length = 0.008;
  }
  Solver solver(Scene(body.mesh, body.options));
  std::vector<double> change;
  for (const double h : {0.4e-3, 0.2e-3, 0.1e-3}) {
    Simulation simulation =
        body.released(solver, Vector3(1e-3, -2e-3, 1e-3), Vector3(0.5, -0.4, 0.6), tight(h, Integrator::bdf2));
    const double first = simulation.kinetic_energy() + simulation.potential_energy();
    REQUIRE(simulation.advance(0.012, nullptr) == Status::converged);
    CHECK((at(simulation.state().positions, turn) / body.arm - Vector3(0.5, -0.4, 0.6)).norm() > 0.5);
    change.push_back(std::abs(simulation.kinetic_energy() + simulation.potential_energy() - first) / first);
    for (const Index n : {4, 5, 6, 7})
      for (const Index m : {4, 5, 6, 7})
        CHECK_WITHIN(std::abs((at(simulation.state().positions, n) - at(simulation.state().positions, m)).norm() -
                              (at(body.mesh.nodes(), n) - at(body.mesh.nodes(), m)).norm()),
                     5e-17);  // rounding
  }
  CHECK_WITHIN(change[2], 5e-4);
  CHECK(change[0] / change[2] > 10.0);
}

TEST_CASE("bone: with tissue and damping it comes to rest in its equilibrium, and copies of the state replay") {
  Bony body;
  body.options.tissue = {1037.0, 486.0, 1e5};
  body.options.density = 1040.0;
  body.options.damping = {40.0, 0.03};
  body.options.gravity = Vector3(2.0, 0.0, -9.81);
  Solver solver(Scene(body.mesh, body.options));
  const Equilibrium rest = settle(solver);
  REQUIRE(rest.report.status == Status::converged);
  Simulation simulation = body.released(solver, Vector3(0, 1e-3, 0), Vector3(0.2, 0.1, 0.3), accurate(2e-3));
  REQUIRE(simulation.advance(0.02, nullptr) == Status::converged);
  const State copy = simulation.state();
  REQUIRE(simulation.advance(0.05, nullptr) == Status::converged);
  const std::vector<double> onward = content(simulation.state());
  simulation.set_state(copy);
  REQUIRE(settle(solver).report.status == Status::converged);  // another solve in between
  REQUIRE(simulation.advance(0.05, nullptr) == Status::converged);
  CHECK(content(simulation.state()) == onward);
  REQUIRE(simulation.advance(1.5, nullptr) == Status::converged);
  CHECK_WITHIN(distance(simulation.state().positions, rest.positions), 2e-11);
}

}  // namespace glossa::test
