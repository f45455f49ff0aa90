#include "effect/muscle_force.hpp"

#include "../muscle/fibres.hpp"

namespace glossa::test {
namespace {

/// Three muscles of block(2, 2, 2) in a general deformed state.
struct Muscles {
  HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  Macrofibres fibres = three_fibres(mesh);
  MuscleForce effect{fibres, ForceLaw{}};
  FreeMask free = FreeMask(mesh.nodes().size(), 1);
  Trial trial;

  /// lambda = length - activation at the deformed state.
  explicit Muscles(const std::vector<double>& activation) {
    soften_segments(fibres, mesh.nodes());
    trial.positions = sum(mesh.nodes(), Random(81).field(mesh.nodes().size(), 2e-3));
    trial.velocities.assign(trial.positions.size(), 0.0);
    effect.measure(trial);
    std::vector<double> lambda = effect.lengths();
    for (std::size_t f = 0; f < 3; ++f) lambda[f] -= activation[f];
    effect.set_lambda(lambda);
    effect.measure(trial);
  }
  Vector force(const Trial& at_trial) {
    Trial measured = at_trial;
    effect.measure(measured);
    NodeField result(measured.positions.size(), 0.0);
    effect.add_force(measured, result);
    return as_vector(result);
  }
  [[nodiscard]] double energy(const Trial& at_trial) {
    Trial measured = at_trial;
    effect.measure(measured);
    return effect.energy(measured);
  }
  /// The assembled tangent of all components; rows of the outside point stay empty.
  Eigen::MatrixXd tangent() {
    force(trial);
    BlockMatrix matrix(mesh.node_count(), free, mesh.hexahedra(), effect.couplings(), &natural_order);
    effect.bind(matrix);
    matrix.gather(std::vector<double>(8 * 324, 0.0), 0.0, 1);
    effect.add_tangent(trial, matrix);
    const auto n = static_cast<Eigen::Index>(trial.positions.size());
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(n, n);
    result(matrix.component_of_unknown(), matrix.component_of_unknown()) = dense(matrix.columns(1));
    return result;
  }
  /// d force / d positions with V following at velocity_share, by differences; columns of the outside point left out.
  Eigen::MatrixXd differences() {
    const auto n = static_cast<Eigen::Index>(trial.positions.size());
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index k = 0; k < n - 3; ++k)
      result.col(k) = derivative(
          [&](double h) -> Vector {
            Trial moved = trial;
            moved.positions[static_cast<std::size_t>(k)] += h;
            moved.velocities[static_cast<std::size_t>(k)] += trial.velocity_share * h;
            return force(moved);
          },
          2e-6);
    result.bottomRows(3).setZero();
    force(trial);
    return result;
  }
};

// Silent, active and saturated in every fibre in turn.
const std::vector<std::vector<double>> regimes{
    {-0.004, 0.008, 0.03}, {0.03, -0.004, 0.008}, {0.008, 0.03, -0.004}, {0.002, 0.009, 0.016}};

}  // namespace

TEST_CASE("muscle force: tension is capacity times level, in line with the segments") {
  Muscles m({0.010, 0.030, -0.004});
  const Vector force = m.force(m.trial);
  const double rest = ForceLaw{}.velocity_factor(0.0);
  CHECK_WITHIN(std::abs(m.effect.tensions()[0] / (2.0 * std::expm1(0.4) * rest) - 1.0), 1e-14);
  CHECK_WITHIN(std::abs(m.effect.tensions()[1] / (3.0 * rest) - 1.0), 1e-15);
  CHECK(m.effect.tensions()[2] == 0.0);
  const Vector3 d = at(m.trial.positions, 26) - at(m.trial.positions, 23);
  const double rest_length = (at(m.mesh.nodes(), 26) - at(m.mesh.nodes(), 23)).norm();
  const Vector3 end = d / std::hypot(d.norm(), 0.01 * rest_length);
  CHECK_WITHIN((force.segment<3>(3 * 26) - m.effect.tensions()[0] * end).norm(), 1e-15);  // resists lengthening
}

TEST_CASE("muscle force: the force is the gradient of the energy, silent, active and saturated") {
  for (const auto& activation : regimes) {
    Muscles m(activation);
    const Vector force = m.force(m.trial);
    Vector reference(force.size());
    for (Eigen::Index k = 0; k < force.size(); ++k)
      reference(k) = slope(
          [&](double h) {
            Trial moved = m.trial;
            moved.positions[static_cast<std::size_t>(k)] += h;
            return m.energy(moved);
          },
          1e-5);
    CHECK_WITHIN(worst_entry(force, reference), 5e-11);  // truncation (h / l)^4, rounding eps E / (h f)
    CHECK(force != reference);
  }
}

TEST_CASE("muscle force: the static tangent is the derivative of the force, silent, active and saturated") {
  for (const auto& activation : regimes) {
    Muscles m(activation);
    const Eigen::MatrixXd tangent = m.tangent(), reference = m.differences();
    CHECK_WITHIN(worst_entry(tangent, reference), 1e-10);  // truncation (h / l)^4, rounding eps / h
    CHECK(tangent != reference);
  }
}

TEST_CASE("muscle force: given activations do not follow the length") {
  Muscles m({0.008, 0.008, 0.008});
  m.trial.activation_follows = false;
  CHECK_WITHIN(worst_entry(m.tangent(), m.differences()), 3e-11);
}

TEST_CASE("muscle force: rates enter the tangent through eq. 5 and, undelayed, through eq. 2") {
  for (const auto& activation : regimes)
    for (const bool follows : {true, false}) {
      Muscles m(activation);
      m.trial.activation_follows = follows;
      m.trial.velocity_share = 400.0;  // a stage of 2.5 ms
      m.trial.rate_gain = follows ? 0.01 : 0.0;
      const Eigen::MatrixXd with = m.tangent();
      CHECK_WITHIN(worst_entry(with, m.differences()), 1e-8);  // truncation: the rate moves 400 times faster
      m.trial.velocity_share = 0.0;
      CHECK(worst_entry(m.tangent(), with) > 1e-2);
    }
}

TEST_CASE("muscle force: the tangent is exact for motion along a straight fibre, shortening or lengthening") {
  for (const double speed : {-0.03, 0.02}) {
    Muscles m({-1.0, 0.006, -1.0});
    Macrofibres straight;
    add_fibre(straight, 0, {9, 17}, 3.0, 2.0, m.mesh.nodes());
    m.fibres = straight;
    MuscleForce effect(m.fibres, ForceLaw{});
    m.trial.activation = {0.006};
    const Vector3 n = (at(m.trial.positions, 17) - at(m.trial.positions, 9)).normalized();
    Eigen::Map<Vector3>(m.trial.velocities.data() + 3 * 17) = speed * n;
    m.trial.velocity_share = 400.0;
    m.trial.activation_follows = false;
    effect.measure(m.trial);
    NodeField scratch(m.trial.positions.size(), 0.0);
    effect.add_force(m.trial, scratch);
    NodeField x = Random(82).field(scratch.size(), 1.0), product(scratch.size(), 0.0);
    effect.multiply(m.trial, x, product);
    const Vector reference = derivative(
        [&](double t) -> Vector {
          Trial moved = m.trial;
          moved.positions = sum(m.trial.positions, x, t);
          moved.velocities = sum(m.trial.velocities, x, 400.0 * t);
          effect.measure(moved);
          NodeField force(x.size(), 0.0);
          effect.add_force(moved, force);
          return as_vector(force);
        },
        1e-6);
    CHECK_WITHIN(worst_entry(as_vector(product), reference), 5e-9);  // truncation of the tension curve along x
  }
}

TEST_CASE("muscle force: multiply is the assembled matrix times a field") {
  for (const auto& activation : regimes) {
    Muscles m(activation);
    m.trial.velocity_share = 400.0;
    const Eigen::MatrixXd tangent = m.tangent();
    NodeField x = Random(83).field(m.trial.positions.size(), 1.0), product(x.size(), 0.0);
    std::fill(x.end() - 3, x.end(), 0.0);  // the outside point does not move
    m.effect.multiply(m.trial, x, product);
    std::fill(product.end() - 3, product.end(), 0.0);
    CHECK_WITHIN(worst_entry(as_vector(product), (tangent * as_vector(x)).eval()), 1e-14);
  }
}

TEST_CASE("muscle force: held nodes take no rows") {
  Muscles m({0.002, 0.009, 0.016});
  const Eigen::MatrixXd whole = m.tangent();
  for (const std::size_t c : {12, 13, 14, 3 * 13 + 1}) m.free[c] = 0;  // node 4, and y of node 13
  Eigen::MatrixXd expected = whole;
  for (const Eigen::Index c : {12, 13, 14, 3 * 13 + 1}) {
    expected.row(c).setZero();
    expected.col(c).setZero();
  }
  CHECK_WITHIN(worst_entry(m.tangent(), expected), 1e-15);
}

}  // namespace glossa::test
