#include "scene/linear_motion.hpp"

#include "bodies.hpp"

namespace glossa::test {
namespace {

const std::vector<double> commands{0.8, 0.7, 0.9};

}  // namespace

TEST_CASE("linear motion: its matrices are derivatives of its forces, for both laws of damping") {
  for (const DampingLaw law : {DampingLaw::material, DampingLaw::tangent}) {
    const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
    SceneOptions options = muscular(mesh);
    options.damping.law = law;
    Solver solver(Scene(mesh, options));
    const Equilibrium rest = settle(solver, commands);
    REQUIRE(rest.report.status == Status::converged);
    LinearMotion motion(solver.scene(), {true, true, true}, commands, {rest.positions, {}, {}, {}});
    const auto n = static_cast<Eigen::Index>(motion.unknowns().size());
    const std::vector<double> active = motion.activation();
    REQUIRE(active.size() == motion.active().size());
    REQUIRE(active.size() >= 2);
    const Vector still = Vector::Zero(n);
    CHECK_WITHIN(motion.force(still, still, active).norm() / rest.report.force_scale, 1e-8);

    const Vector move = as_vector(Random(51).field(static_cast<std::size_t>(n), 1.0));
    const Eigen::MatrixXd stiffness = dense(motion.matrix(0.0, 0.0)), faster = dense(motion.matrix(30.0, 0.0));
    const Vector by_place = derivative([&](double h) { return motion.force(h * move, still, active); }, 1e-7);
    const Vector by_rate = derivative([&](double h) { return motion.force(still, h * move, active); }, 1e-3);
    CHECK_WITHIN(worst_entry(Vector(stiffness * move), by_place), 1e-9);
    CHECK_WITHIN(worst_entry(Vector((faster - stiffness) * move / 30.0), by_rate), 1e-8);

    const std::vector<double> pulls = motion.pulls(), gradients = motion.gradients();
    for (std::size_t f = 0; f < active.size(); ++f) {
      const Vector by_activation = derivative(
          [&](double h) {
            std::vector<double> changed = active;
            changed[f] += h;
            return motion.force(still, still, changed);
          },
          1e-5);
      const Eigen::Map<const Vector> pull(pulls.data() + static_cast<Eigen::Index>(f) * n, n);
      CHECK_WITHIN(worst_entry(Vector(pull), by_activation), 5e-12);
      const Eigen::Map<const Vector> gradient(gradients.data() + static_cast<Eigen::Index>(f) * n, n);
      const auto length = [&](double h) {
        NodeField moved = rest.positions;
        for (Eigen::Index k = 0; k < n; ++k)
          moved[static_cast<std::size_t>(motion.unknowns()[static_cast<std::size_t>(k)])] += h * move(k);
        return solver.scene().fibre_lengths(moved)[static_cast<std::size_t>(motion.active()[f])];
      };
      CHECK_WITHIN(std::abs(gradient.dot(move) - slope(length, 1e-6)) / std::abs(gradient.dot(move)), 5e-10);
    }
  }
}

TEST_CASE("linear motion: arrays that do not fit are refused") {
  const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  Solver solver(Scene(mesh, muscular(mesh)));
  const NodeField few(3, 0.0);
  CHECK_THROWS_WITH_AS(LinearMotion(solver.scene(), {true, true, true}, commands, {few, {}, {}, {}}),
                       doctest::Contains("positions must fit the body"), InputError);
}

}  // namespace glossa::test
