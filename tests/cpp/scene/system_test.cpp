#include "scene/system.hpp"

#include "bodies.hpp"

namespace glossa::test {

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
    system.add_free(u, 1.0, moved.positions);
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
  Report report;
  system.assemble(evaluated(u0).second, 0.0, report);
  CHECK_WITHIN(worst_entry(dense(system.columns()), tangent), 8e-11);
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
  system.assemble(trial, 0.0, report);
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
  system.assemble(trial, 0.0, report);
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
