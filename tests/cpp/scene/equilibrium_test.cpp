#include "scene/equilibrium.hpp"

#include "bodies.hpp"

namespace glossa::test {
namespace {

Vector3 support(const Equilibrium& result, const FreeMask& free) {
  Vector3 total = Vector3::Zero();
  for (std::size_t k = 0; k < free.size(); ++k)
    if (!free[k]) total(static_cast<Eigen::Index>(k % 3)) += result.force[k];
  return total;
}

}  // namespace

TEST_CASE("equilibrium: a block under gravity, residual, sag and support") {
  std::vector<double> sag;
  for (const ElementKind kind : {ElementKind::q1p0, ElementKind::q1}) {
    const HexMesh mesh = block(3, 3, 3, 0.1);
    SceneOptions options = passive(mesh, 3, 3);
    options.element = kind;
    Solver solver(Scene(mesh, options));
    const Equilibrium result = settle(solver);
    REQUIRE(result.report.status == Status::converged);
    CHECK(result.report.force_scale > 0.1);
    CHECK_WITHIN(result.report.residual / result.report.force_scale, 1e-8);
    const Vector3 weight = 1040.0 * volume_of(mesh) * Vector3(0, 0, -9.81);
    CHECK_WITHIN((support(result, options.free) + weight).norm() / weight.norm(), 1e-8);
    sag.push_back(mesh.nodes().back() - result.positions.back());
    CHECK(result.report.least_jacobian > 0.5);
    CHECK(result.report.indefinite == 0);
  }
  CHECK(sag[0] > 1e-4);
  CHECK(sag[1] < 0.7 * sag[0]);  // plain Q1 locks
}

TEST_CASE("equilibrium: muscles, stiffening and an outside point; the solution does not depend on the start") {
  const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  Solver solver(Scene(mesh, muscular(mesh)));
  const std::vector<double> command{0.7, silent, 0.8};
  const Equilibrium result = settle(solver, command);
  REQUIRE(result.report.status == Status::converged);
  CHECK_WITHIN(result.report.residual / result.report.force_scale, 1e-8);
  CHECK(result.tension[0] > 0.05);
  CHECK(result.tension[1] == 0.0);
  CHECK(result.stiffening[0] > 1.2);
  const double a =
      solver.scene().fibre_lengths(result.positions)[0] - 0.7 * solver.scene().options().fibres.rest_length[0];
  CHECK_WITHIN(std::abs(result.activation[0] - a), 1e-15);
  System& system = *solver.system(solver.scene().options().free, {true, false, true});
  NodeField start = result.positions;
  for (std::size_t k = 0; k < start.size(); ++k)
    if (solver.scene().options().free[k]) start[k] += 1e-3 * std::sin(7.0 * static_cast<double>(k));
  const Equilibrium again = equilibrate(system, start, {}, mesh.nodes(), {});
  REQUIRE(again.report.status == Status::converged);
  CHECK_WITHIN(distance(again.positions, result.positions), 6e-11);  // tolerance over the softest mode
}

TEST_CASE("equilibrium: held nodes follow their target, a block pressed together by 30 %") {
  const HexMesh mesh = block(3, 3, 3);
  SceneOptions options = passive(mesh, 3, 3);
  options.gravity.reset();
  Solver solver(Scene(mesh, options));
  FreeMask free = options.free;
  NodeField target = mesh.nodes();
  for (std::size_t k = 3 * 48; k < free.size(); ++k) {
    free[k] = 0;
    if (k % 3 == 2) target[k] *= 0.7;
  }
  const Equilibrium result = equilibrate(*solver.system(free, {}), mesh.nodes(), {}, target, {});
  REQUIRE(result.report.status == Status::converged);
  CHECK_WITHIN(result.report.residual / result.report.force_scale, 1e-8);
  for (std::size_t k = 0; k < free.size(); ++k)
    if (!free[k]) CHECK(result.positions[k] == target[k]);
  CHECK(result.report.least_jacobian > 0.2);
  double top = 0.0, bottom = 0.0;
  for (std::size_t n = 0; n < 16; ++n) bottom += result.force[3 * n + 2];
  for (std::size_t n = 48; n < 64; ++n) top += result.force[3 * n + 2];
  CHECK(top < -1.0);                                           // the plate pushes down
  CHECK_WITHIN(std::abs(top + bottom) / std::abs(top), 1e-8);  // the tolerance of the solve
}

TEST_CASE("equilibrium: external loads are carried by the support") {
  const HexMesh mesh = block(2, 2, 2);
  SceneOptions options = passive(mesh, 2, 2);
  options.gravity.reset();
  Solver solver(Scene(mesh, options));
  System& system = *solver.system(options.free, {});
  NodeField load(mesh.nodes().size(), 0.0);
  load[3 * 26] = 0.05;
  load[3 * 22 + 1] = -0.03;
  system.set_load(load);
  const Equilibrium result = equilibrate(system, mesh.nodes(), {}, mesh.nodes(), {});
  REQUIRE(result.report.status == Status::converged);
  CHECK_WITHIN((support(result, options.free) - Vector3(-0.05, 0.03, 0.0)).norm() / 0.05,
               3e-8);  // residual over force scale; the scale is larger than the load
}

TEST_CASE("equilibrium: same bits for one, two and three threads") {
  const HexMesh mesh = block(10, 10, 8, 0.1);
  std::vector<Equilibrium> results;
  for (const int threads : {1, 2, 3}) {
    SceneOptions options = passive(mesh, 10, 10);
    options.threads = threads;
    Solver solver(Scene(mesh, options));
    results.push_back(settle(solver));
    CHECK(results.back().report.status == Status::converged);
    CHECK(results.back().positions == results.front().positions);
    CHECK(results.back().pressure == results.front().pressure);
  }
}

TEST_CASE("equilibrium: an unsupported body is refused") {
  const HexMesh mesh = block(2, 2, 2);
  SceneOptions options;
  options.gravity = Vector3(0, 0, -9.81);
  Solver solver(Scene(mesh, options));
  CHECK_THROWS_AS(settle(solver), InputError);
}

TEST_CASE("equilibrium: failures end with a status and the last good state") {
  const HexMesh mesh = block(2, 2, 2);
  Solver solver(Scene(mesh, passive(mesh, 2, 2)));
  System& system = *solver.system(solver.scene().options().free, {});
  const NodeField& rest = mesh.nodes();
  const auto status = [&](const EquilibriumOptions& options, const NodeField& start,
                          const std::vector<double>& pressure) {
    return equilibrate(system, start, pressure, rest, options).report.status;
  };
  EquilibriumOptions one_iteration, stopped;
  one_iteration.max_iterations = 1;
  one_iteration.quasi_newton = false;
  int calls = 0;
  stopped.interrupt = [&] { return ++calls > 1; };
  CHECK(status(one_iteration, rest, {}) == Status::iteration_limit);
  CHECK(status(stopped, rest, {}) == Status::interrupted);
  NodeField turned_inside_out = rest;
  turned_inside_out[3 * 26 + 2] = 0.0;
  CHECK(status({}, turned_inside_out, {}) == Status::inverted);
  CHECK(status({}, rest, std::vector<double>(8, -1e9)) == Status::indefinite);
  CHECK(status({}, rest, {}) == Status::converged);
}

}  // namespace glossa::test
