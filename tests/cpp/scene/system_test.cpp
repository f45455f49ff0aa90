#include "scene/system.hpp"

#include "../effect/touching.hpp"
#include "bodies.hpp"

namespace glossa::test {
namespace {

/// block(2, 2, 2) with muscles, gravity, a ball and a roof above its top, and a bone: three nodes of its rear edge and
/// an outside point on springs; pose at 29 and 30. `mirrored`: the pose of a half.
struct Everything {
  HexMesh mesh = body();
  SceneOptions options;

  static HexMesh body() {
    const HexMesh plain = block(2, 2, 2, 0.15, 0.01, 1);
    NodeField nodes = plain.nodes();
    for (const double x : {0.024, 0.021, 0.013,                                     // 28, on the bone
                           0.022, 0.019, 0.012, 0.0, 0.0, 0.0,                      // 29 and 30, its pose
                           0.04, 0.03, 0.02, 0.03, 0.04, 0.0, 0.02, 0.021, 0.045})  // 31 to 33, anchors
      nodes.push_back(x);
    return {std::move(nodes), plain.hexahedra()};
  }
  explicit Everything(bool mirrored) : options(muscular(mesh)) {
    options.tissue.kappa = 2e4;
    options.stiffening = false;
    options.bone = Bone{{{14, 17, 26, 28}, 29, 30},
                        {{14, 0.01}, {28, 0.003}},
                        {{28, 31, 220.0, 0.01}, {28, 32, 220.0, 0.03}, {17, 31, 110.0, 0.02}, {26, 33, 90.0, 0.03}}};
    if (mirrored)
      for (const std::size_t c : {88, 90, 92}) options.free[c] = 0;
    ContactPoints points = top_points(2, 2, 2);
    for (std::size_t k = 0; k < points.wall.size(); k += 2) points.wall[k] = 1;
    options.contact =
        ContactOptions{points, {field_at(sphere(0.02, 60), Vector3(0.012, 0.009, 0.0385)), roof(0.0195)}, 0.3};
  }
};

}  // namespace

TEST_CASE("system: the sum of forces is the gradient of the energy, the matrix its derivative") {
  const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  SceneOptions options = muscular(mesh);
  options.tissue.kappa = 2e4;
  options.stiffening = false;
  Solver solver(Scene(mesh, options));
  System& system = *solver.system(solver.scene().options().free, {true, true, true});
  system.set_command({0.8, 0.7, 0.9});
  NodeField load = Random(111).field(mesh.nodes().size(), 0.01);
  system.set_load(load);
  Trial trial = system.rest_trial();
  const auto evaluated = [&](const Vector& u) {
    Trial moved = trial;
    system.move(u, 1.0, moved.positions);
    system.measure(moved);
    NodeField force;
    system.force(moved, force);
    system.elasticity().set_pressure(moved.pressure);
    return std::pair{system.restrict_free(force), moved};
  };
  const Vector u0 = as_vector(Random(112).field(54, 1e-3));
  const Vector force = evaluated(u0).first;
  Vector gradient(54);
  Eigen::MatrixXd tangent(54, 54);
  for (Eigen::Index k = 0; k < 54; ++k) {
    gradient(k) = slope([&](double h) { return system.energy(evaluated(u0 + h * Vector::Unit(54, k)).second); }, 1e-5);
    tangent.col(k) = derivative([&](double h) { return evaluated(u0 + h * Vector::Unit(54, k)).first; }, 1e-5);
  }
  CHECK_WITHIN(worst_entry(force, gradient), 9e-11);  // truncation (h / l)^4
  system.assemble(evaluated(u0).second, 0.0);
  CHECK_WITHIN(worst_entry(dense(system.columns()), tangent), 8e-11);
}

TEST_CASE("system: the same with walls, friction and a bone, of a whole body and of a mirrored half") {
  for (const bool mirrored : {false, true}) {
    const Everything body(mirrored);
    Solver solver(Scene(body.mesh, body.options));
    const FreeMask& free = solver.scene().options().free;
    System& system = *solver.system(free, {true, true, true});
    const Eigen::Index n = 3 * (27 - 9 - 3) + (mirrored ? 3 : 6);
    REQUIRE(static_cast<Eigen::Index>(system.component_of_unknown().size()) == n);
    system.set_command({0.8, 0.7, 0.9});
    Trial trial = system.rest_trial();
    // The layout with contact, which numbers the unknowns, comes with the first tangent of a touching state.
    Trial raised = trial;
    for (std::size_t k = 2; k < raised.positions.size(); k += 3) raised.positions[k] += 1e-3;
    NodeField raised_force;
    system.measure(raised);
    system.force(raised, raised_force);
    system.reduce(raised, raised_force);
    REQUIRE(system.contact()->active_count() > 0);
    system.assemble(raised, 0.0);
    const auto evaluated = [&](const Vector& u, const NodeField& held, double h) {
      Trial moved = trial;
      system.move(u, 1.0, moved.positions);
      for (std::size_t k = 0; k < held.size(); ++k) moved.positions[k] += h * held[k];
      system.measure(moved);
      NodeField force;
      system.force(moved, force);
      system.reduce(moved, force);
      system.elasticity().set_pressure(moved.pressure);
      return std::pair{system.restrict_free(force), moved};
    };
    // Bounds of friction from a first place, slips to a second; the bone turned by a third of a radian.
    const NodeField none(body.mesh.nodes().size(), 0.0);
    const auto size = static_cast<std::size_t>(n);
    Vector u0 = as_vector(Random(114).field(size, 3e-4));
    for (Eigen::Index k = 0; k < n; ++k)
      if (system.component_of_unknown()[static_cast<std::size_t>(k)] >= 90) u0(k) = 2e-3;
    const Trial first = evaluated(u0, none, 0.0).second;
    system.contact()->update(0.0);
    system.contact()->update_bounds(1.0);
    system.contact()->begin_increment(first.positions, {Vector3::Zero(), Vector3::Zero()});
    u0 += as_vector(Random(115).field(size, 3e-5));
    const Vector force = evaluated(u0, none, 0.0).first;
    REQUIRE(system.contact()->active_count() > 8);
    REQUIRE(system.contact()->penetration() > 1e-4);
    Vector gradient(n);
    Eigen::MatrixXd tangent(n, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      gradient(k) = slope(
          [&](double h) { return system.energy(evaluated(u0 + h * Vector::Unit(n, k), none, 0.0).second); }, 1e-7);
      tangent.col(k) =
          derivative([&](double h) { return evaluated(u0 + h * Vector::Unit(n, k), none, 0.0).first; }, 3e-8);
    }
    CHECK_WITHIN(worst_entry(force, gradient), 2e-9);  // rounding eps E / (h f)
    // Held components move: what advance() of an equilibrium predicts.
    NodeField held(none.size(), 0.0), product(none.size(), 0.0);
    for (std::size_t k = 0; k < 27; ++k) held[k] = 0.1 * static_cast<double>(k % 4) - 0.1;
    const Vector coupling = derivative([&](double h) { return evaluated(u0, held, h).first; }, 4e-6);
    const Trial last = evaluated(u0, none, 0.0).second;
    system.assemble(last, 0.0);
    CHECK_WITHIN(worst_entry(dense(system.columns()), tangent), 1e-8);  // rounding eps f / (h K)
    system.multiply(last, held, product);
    CHECK_WITHIN(worst_entry(system.restrict_free(product), coupling), 1e-8);
    // Increments to first order follow moves.
    const Vector step = as_vector(Random(116).field(size, 1.0));
    const NodeField spread = system.spread(step, 1e-2, last.positions);
    const Vector moved = derivative(
        [&](double h) -> Vector {
          NodeField positions = last.positions;
          system.move(step, h, positions);
          return as_vector(positions);
        },
        1e-6);
    CHECK_WITHIN(worst_entry(as_vector(spread), (1e-2 * moved).eval()), 3e-10);
    for (const std::size_t tied : {14, 17, 26, 28}) {
      CHECK(at(spread, static_cast<Index>(tied)).norm() > 0.0);
      for (std::size_t i = 0; i < 3; ++i) {
        CHECK(system.free()[3 * tied + i] == 0);
        CHECK(system.moving()[3 * tied + i] == 1);
      }
    }
  }
}

TEST_CASE("system: mass of tissue and bone in the reduced matrix is that of the kinetic energy") {
  const Everything body(false);
  Solver solver(Scene(body.mesh, body.options));
  System& system = *solver.system(solver.scene().options().free, {false, false, false});
  Trial trial = system.rest_trial();
  NodeField force;
  system.force(trial, force);
  system.reduce(trial, force);
  system.assemble(trial, 0.0);
  const Eigen::MatrixXd without = dense(system.columns());
  system.assemble(trial, 1e6);
  const Eigen::MatrixXd mass = (dense(system.columns()) - without) / 1e6;
  const Vector v = as_vector(Random(117).field(static_cast<std::size_t>(mass.rows()), 1.0));
  const NodeField velocity = system.spread(v, 1.0, trial.positions);
  NodeField momentum(velocity.size(), 0.0);
  system.inertia().multiply(1.0, velocity, momentum);
  const double expected = as_vector(momentum).dot(as_vector(velocity));
  CHECK(expected > 1e-3);
  CHECK_WITHIN(std::abs(v.dot(mass * v) / expected - 1.0), 1e-13);  // rounding of the stiffness taken off
}

TEST_CASE("system: an indefinite tangent is shifted until it serves, and counted") {
  const HexMesh mesh = block(2, 2, 2);
  Solver solver(Scene(mesh, passive(mesh, 2, 2)));
  System& system = *solver.system(solver.scene().options().free, {});
  Trial trial = system.rest_trial();
  trial.positions = sum(mesh.nodes(), Random(113).field(mesh.nodes().size(), 1e-3));
  NodeField force;
  system.force(trial, force);
  trial.pressure.assign(trial.pressure.size(), -5e5);
  Report report;
  system.assemble(trial, 0.0);
  CHECK(system.factorise(report));
  CHECK(report.indefinite == 1);
  CHECK(report.factorisations > 1);
  Vector step = system.restrict_free(force), rough = step;
  const Vector G = step;
  system.newton_step(step);
  system.precondition(rough);
  CHECK_WITHIN(worst_entry(rough, step), 2e-5);        // single precision
  CHECK(G.dot(step) < 0.0);                            // a direction of descent
  trial.pressure.assign(trial.pressure.size(), -1e9);  // beyond the largest shift
  system.assemble(trial, 0.0);
  CHECK_FALSE(system.factorise(report));
}

TEST_CASE("system: silent muscles take no entries in the matrix") {
  const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  SceneOptions options = muscular(mesh);
  add_fibre(options.fibres, 0, {9, 26}, 1.0, 1.0, mesh.nodes());  // couples nodes of no common element
  Solver solver(Scene(mesh, options));
  const FreeMask& free = solver.scene().options().free;
  const auto entries = [&](std::vector<bool> commanded) {
    return solver.system(free, commanded)->columns().row.size();
  };
  CHECK(entries({false, false, true}) == entries({false, false, false}));
  CHECK(entries({true, false, false}) > entries({false, false, false}));
}

TEST_CASE("system: a body that is free to move rigidly is refused") {
  const HexMesh mesh = block(2, 2, 2);
  const auto held = [&](const std::vector<std::size_t>& components) {
    FreeMask free(mesh.nodes().size(), 1);
    for (const std::size_t c : components) free[c] = 0;
    return free;
  };
  CHECK_THROWS_WITH_AS(require_supported(mesh, held({})),
                       "constraints: the held nodes leave the body free to move rigidly (6 of 6 rigid motions), so no "
                       "equilibrium is unique; hold at least three nodes that are not on one line",
                       InputError);
  // Three nodes on one line leave a rotation; a mirror plane leaves three motions.
  const auto message = [&](const FreeMask& free) -> std::string {
    try {
      require_supported(mesh, free);
    } catch (const InputError& error) {
      return error.what();
    }
    return "supported";
  };
  CHECK(message(held({0, 1, 2, 3, 4, 5, 6, 7, 8})).find("(1 of 6 rigid motions)") != std::string::npos);
  CHECK(message(held({1, 4, 10, 28, 31})).find("(3 of 6 rigid motions)") != std::string::npos);
  CHECK(message(held({0, 1, 2, 4, 5, 11})) == "supported");
}

}  // namespace glossa::test
