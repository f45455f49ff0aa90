#include <Eigen/Eigenvalues>

#include "../fixture.hpp"
#include "effect/elasticity.hpp"

namespace glossa::test {
namespace {

const Yeoh soft{1037.0, 486.0, 2.0e4};  // bulk part of the size of the isochoric one, so that neither hides the other

Trial trial_at(const NodeField& positions, std::size_t padded) {
  Random random(51);
  Trial trial;
  trial.positions = positions;
  for (std::size_t e = 0; e < padded; ++e) trial.isochoric_scale.push_back(random(1.0, 8.0));
  trial.pressure.assign(padded, 0.0);
  trial.elastic_share = 1.3;
  return trial;
}

NodeField force_of(Elasticity& elasticity, const Trial& trial) {
  NodeField force(trial.positions.size(), 0.0);
  elasticity.add_force(trial, force);
  return force;
}

/// Two distorted elements of 27 nodes in a general state: less than a batch.
struct General {
  HexMesh mesh = block(4, 2, 2, 0.2);
  std::shared_ptr<const RestBatches> rest = rest_batches(mesh, ElementKind::q2p1);
  Elasticity elasticity{mesh, rest, soft, ElementKind::q2p1, 1};
  Trial trial = trial_at(sum(mapped(mesh.nodes(), rotation()), Random(52).field(mesh.nodes().size(), 1e-3)),
                         elasticity.padded_count());
  [[nodiscard]] BlockMatrix matrix() const {
    return {mesh.node_count(), FreeMask(mesh.nodes().size(), 1), rest->cells, {}, &natural_order};
  }
  [[nodiscard]] Eigen::MatrixXd tangent() {
    BlockMatrix result = matrix();
    elasticity.add_tangent(trial, result);
    return dense(result.columns(1));
  }
};

/// The linear function nearest to values at the octants of a cell, at those octants.
std::vector<double> projected(const RestBatches& rest, const std::vector<double>& values) {
  std::vector<double> result(values.size(), 0.0);
  for (std::size_t c = 0; c < rest.cells.count(); ++c)
    for (std::size_t o = 0; o < 8; ++o)
      for (std::size_t p = 0; p < 8; ++p) {
        double weight = 0.125;
        for (std::size_t d = 0; d < 3; ++d) weight += (o >> d & 1U) == (p >> d & 1U) ? 0.125 : -0.125;
        const auto& octant = rest.quadratic[c / lanes].octant;
        result[static_cast<std::size_t>(octant[o][c % lanes])] +=
            weight * values[static_cast<std::size_t>(octant[p][c % lanes])];
      }
  return result;
}

}  // namespace

TEST_CASE("quadratic elasticity: the force is the gradient of the energy") {
  General g;
  const NodeField force = force_of(g.elasticity, g.trial);
  NodeField reference(force.size());
  for (std::size_t k = 0; k < force.size(); ++k)
    reference[k] = slope(
        [&](double h) {
          Trial moved = g.trial;
          moved.positions[k] += h;
          force_of(g.elasticity, moved);
          return g.elasticity.energy(moved);
        },
        5e-6);
  CHECK_WITHIN(worst_entry(force, reference), 1e-9);  // eps E / (h f), truncation (h / l)^4
}

TEST_CASE("quadratic elasticity: the tangent is the derivative of the force where p = kappa (theta - 1)") {
  General g;
  force_of(g.elasticity, g.trial);
  g.elasticity.set_pressure(g.trial.pressure);
  const Eigen::MatrixXd tangent = g.tangent();
  Eigen::MatrixXd reference(tangent.rows(), tangent.cols());
  for (Eigen::Index k = 0; k < reference.cols(); ++k)
    reference.col(k) = derivative(
        [&](double h) -> Vector {
          Trial moved = g.trial;
          moved.positions[static_cast<std::size_t>(k)] += h;
          return as_vector(force_of(g.elasticity, moved));
        },
        5e-6);
  CHECK_WITHIN(worst_entry(tangent, reference), 1e-9);  // as above
  const NodeField x = Random(53).field(g.trial.positions.size(), 1.0);
  NodeField product;
  g.elasticity.multiply(x, product);
  CHECK_WITHIN(worst_entry(as_vector(product), (tangent * as_vector(x)).eval()), 1e-13);
}

TEST_CASE(
    "quadratic elasticity: viscous forces are linear in the velocities, and their share of the tangent says how") {
  General g;
  const NodeField v = Random(57).field(g.trial.positions.size(), 0.1);
  g.trial.viscosity = 0.03;
  g.trial.velocities.assign(v.size(), 0.0);
  const NodeField still = force_of(g.elasticity, g.trial);
  const Eigen::MatrixXd elastic = g.tangent();
  g.trial.velocity_share = 200.0;
  const Eigen::MatrixXd both = g.tangent();
  g.trial.velocities = v;
  const Vector viscous = as_vector(force_of(g.elasticity, g.trial)) - as_vector(still);
  CHECK_WITHIN(worst_entry(viscous, ((both - elastic) * as_vector(v) / 200.0).eval()), 1e-11);
  CHECK(as_vector(v).dot(viscous) > 0.0);
}

TEST_CASE("quadratic elasticity: viscosity takes power from every motion but rigid ones") {
  General g;
  for (double& p : g.trial.pressure) p = 2e4;  // strong tension across the elements: buckling modes
  g.trial.velocity_share = 1.0;
  const Eigen::MatrixXd elastic = g.tangent();
  g.trial.viscosity = 1.0;
  g.trial.velocities.assign(g.trial.positions.size(), 0.0);
  const Eigen::MatrixXd viscous = g.tangent() - elastic;
  const auto least = [](const Eigen::MatrixXd& matrix) {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix).eigenvalues()(0) / matrix.cwiseAbs().maxCoeff();
  };
  CHECK(least(elastic) < -1e-3);
  CHECK(least(viscous) > -1e-13);
  NodeField turn(g.trial.positions.size());
  const Vector3 axis(1.0, -2.0, 0.5);
  for (Index node = 0; node < g.mesh.node_count(); ++node)
    Eigen::Map<Vector3>(turn.data() + 3 * node) = axis.cross(at(g.trial.positions, node)) + Vector3(0.1, 0.2, 0.3);
  CHECK((viscous * as_vector(turn)).norm() < 1e-12 * viscous.norm() * as_vector(turn).norm());
}

TEST_CASE("quadratic elasticity: predicted pressures are the linearised kappa (theta - 1)") {
  General g;
  force_of(g.elasticity, g.trial);
  CHECK(g.tangent().allFinite());
  const NodeField dx = Random(54).field(g.trial.positions.size(), 1e-3);
  std::vector<double> start(g.trial.pressure.size(), 100.0), predicted = start, half = start, now = start;
  g.elasticity.predict_pressure(dx, 1.0, predicted);
  g.elasticity.predict_pressure(dx, 0.5, half);
  g.elasticity.set_pressure(now);
  const Vector change = derivative(
      [&](double t) -> Vector {
        Trial moved = g.trial;
        moved.positions = sum(g.trial.positions, dx, t);
        force_of(g.elasticity, moved);
        std::vector<double> p(start.size(), 0.0);
        g.elasticity.set_pressure(p);
        return as_vector(p);
      },
      1e-2);
  const Vector expected = as_vector(now) + change;
  CHECK_WITHIN(worst_entry(as_vector(predicted), expected), 1e-11);  // rounding of theta - 1 over the difference step
  CHECK_WITHIN(worst_entry(as_vector(half), (0.5 * (expected.array() + 100.0)).matrix().eval()), 1e-11);
}

TEST_CASE("quadratic elasticity: an offset adds to the pressure of force and tangent, by its linear part") {
  General g, plain;
  const std::vector<double> offset = Random(59).field(g.elasticity.padded_count(), 700.0);
  const std::vector<double> linear = projected(*g.rest, offset);
  CHECK(worst_entry(linear, offset) > 0.1);
  g.trial.pressure_offset = offset;
  for (std::size_t e = 0; e < offset.size(); ++e) {
    g.trial.pressure[e] = 100.0;
    plain.trial.pressure[e] = 100.0 + linear[e] / g.trial.elastic_share;
  }
  CHECK_WITHIN(worst_entry(g.tangent(), plain.tangent()), 1e-13);
  // The potential of an offset q is the integral of q J: its force is the change of the force with the offset.
  const Vector with = as_vector(force_of(g.elasticity, g.trial)),
               without = as_vector(force_of(plain.elasticity, plain.trial));
  g.trial.pressure_offset = linear;
  CHECK_WITHIN(worst_entry(as_vector(force_of(g.elasticity, g.trial)), with), 1e-13);
  CHECK(worst_entry(with, without) > 1e-3);
}

TEST_CASE(
    "quadratic elasticity: patch test, a distorted patch under a linear map has one stress and free inner nodes") {
  const HexMesh mesh = block(4, 4, 4, 0.25);
  const Matrix3 F = rotation() * (Matrix3::Identity() + Random(55).matrix(0.2));
  Elasticity elasticity(mesh, rest_batches(mesh, ElementKind::q2p1), soft, ElementKind::q2p1, 1);
  Trial trial = trial_at(mapped(mesh.nodes(), F), elasticity.padded_count());
  trial.isochoric_scale.assign(elasticity.padded_count(), 2.0);
  const NodeField force = force_of(elasticity, trial);
  double inner = 0.0, outer = 0.0;
  for (Index n = 0; n < mesh.node_count(); ++n) {
    const Index i = n % 5, j = n / 5 % 5, k = n / 25;
    double& worst = i % 4 > 0 && j % 4 > 0 && k % 4 > 0 ? inner : outer;
    worst = std::max(worst, at(force, n).norm());
  }
  REQUIRE(outer > 1e-3);
  CHECK_WITHIN(inner / outer, 1e-13);
  for (Index e = 0; e < mesh.element_count(); ++e)
    CHECK_WITHIN(std::abs(elasticity.dilatation()[static_cast<std::size_t>(e)] / F.determinant() - 1.0), 1e-13);
}

TEST_CASE("quadratic elasticity: rest and rigid motion are free of force; forces and moments balance") {
  General g;
  const auto padded = g.elasticity.padded_count();
  const double scale = as_vector(force_of(g.elasticity, trial_at(mapped(g.mesh.nodes(), 1.1 * rotation()), padded)))
                           .cwiseAbs()
                           .maxCoeff();
  const NodeField moved = mapped(g.mesh.nodes(), rotation(), Vector3(0.02, -0.03, 0.01));
  CHECK_WITHIN(as_vector(force_of(g.elasticity, trial_at(moved, padded))).cwiseAbs().maxCoeff() / scale, 1e-12);
  CHECK_WITHIN(std::abs(g.elasticity.least_jacobian() - 1.0), 1e-13);
  const NodeField force = force_of(g.elasticity, g.trial);
  Vector3 total = Vector3::Zero(), moment = Vector3::Zero();
  for (Index n = 0; n < g.mesh.node_count(); ++n) {
    total += at(force, n);
    moment += at(g.trial.positions, n).cross(at(force, n));
  }
  const double size = as_vector(force).cwiseAbs().maxCoeff();
  CHECK_WITHIN(total.norm() / size, 1e-13);
  CHECK_WITHIN(moment.norm() / (0.03 * size), 1e-13);
}

TEST_CASE("quadratic elasticity: an inverted element is seen and named by a hexahedron of its own") {
  General g;
  NodeField positions = g.mesh.nodes();
  positions[0] += 0.035;  // node 0 belongs to the first cell alone
  force_of(g.elasticity, trial_at(positions, g.elasticity.padded_count()));
  CHECK(g.elasticity.least_jacobian() < 0.0);
  CHECK(g.elasticity.worst_element() == 0);
}

TEST_CASE("quadratic elasticity: same bits for one, two and three threads") {
  const HexMesh mesh = block(8, 6, 8, 0.1);  // 12 batches
  const auto rest = rest_batches(mesh, ElementKind::q2p1);
  std::vector<NodeField> forces;
  std::vector<std::vector<double>> matrices;
  for (const int threads : {1, 2, 3}) {
    Elasticity elasticity(mesh, rest, soft, ElementKind::q2p1, threads);
    const Trial trial =
        trial_at(sum(mesh.nodes(), Random(56).field(mesh.nodes().size(), 5e-4)), elasticity.padded_count());
    forces.push_back(force_of(elasticity, trial));
    BlockMatrix matrix(mesh.node_count(), bottom_held(mesh, 8, 6), rest->cells, {}, &natural_order);
    matrix.set_mass(element_masses(mesh, *rest, 1040.0));
    elasticity.set_mass_scale(1e4);
    elasticity.add_tangent(trial, matrix);
    matrices.push_back(matrix.columns(threads).value);
  }
  CHECK(forces[1] == forces[0]);
  CHECK(forces[2] == forces[0]);
  CHECK(matrices[1] == matrices[0]);
  CHECK(matrices[2] == matrices[0]);
}

TEST_CASE("quadratic elasticity: element masses add up to the mass of the body") {
  const HexMesh mesh = block(4, 2, 2);
  const auto rest = rest_batches(mesh, ElementKind::q2p1);
  const std::vector<double> masses = element_masses(mesh, *rest, 1040.0);
  REQUIRE(masses.size() == 2 * 378);
  double total = 0.0;
  std::size_t pair = 0;
  for (int c = 0; c < 2; ++c)
    for (int b = 0; b < 27; ++b)
      for (int a = 0; a <= b; ++a) total += (a == b ? 1.0 : 2.0) * masses[pair++];
  CHECK_WITHIN(std::abs(total / (1040.0 * 16e-6) - 1.0), 1e-13);
}

}  // namespace glossa::test
