#include "effect/elasticity.hpp"

#include <Eigen/Eigenvalues>

#include "reference_element.hpp"

namespace glossa::test {
namespace {

const Yeoh tissue{1037.0, 486.0, 1.0369e6};
const Yeoh soft{1037.0, 486.0, 2.0e4};  // bulk part of the size of the isochoric one, so that neither hides the other

/// A trial of all arrays that elasticity reads, stiffening at random.
Trial trial_at(const NodeField& positions, std::size_t padded, std::uint64_t seed = 51) {
  Random random(seed);
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

/// A distorted mesh of six elements in a general state.
struct General {
  HexMesh mesh = block(3, 1, 2, 0.2);
  Elasticity elasticity;
  Trial trial;
  explicit General(ElementKind kind, const Yeoh& law = soft)
      : elasticity(mesh, rest_batches(mesh), law, kind, 1),
        trial(trial_at(sum(mapped(mesh.nodes(), rotation()), Random(52).field(mesh.nodes().size(), 2e-3)),
                       elasticity.padded_count())) {}
  [[nodiscard]] BlockMatrix matrix() const {
    return {mesh.node_count(), FreeMask(mesh.nodes().size(), 1), mesh.hexahedra(), {}, &natural_order};
  }
};

constexpr std::array kinds{ElementKind::q1p0, ElementKind::q1};

}  // namespace

TEST_CASE("elasticity: forces and tangent of a mesh against straightforward elements, assembled densely") {
  for (const ElementKind kind : kinds) {
    General g(kind);
    Random random(53);
    for (double& p : g.trial.pressure) p = random(-500, 500);
    const auto n = static_cast<Eigen::Index>(g.trial.positions.size());
    Vector force = Vector::Zero(n);
    Eigen::MatrixXd tangent = Eigen::MatrixXd::Zero(n, n);
    for (Index e = 0; e < g.mesh.element_count(); ++e) {
      const auto k = static_cast<std::size_t>(e);
      const ElementResult r =
          reference_element(g.mesh, e, g.trial.positions, soft, {g.trial.isochoric_scale[k], 1.3, g.trial.pressure[k]},
                            kind == ElementKind::q1p0);
      std::vector<Index> rows;
      for (const Index node : g.mesh.hexahedra()[k]) rows.insert(rows.end(), {3 * node, 3 * node + 1, 3 * node + 2});
      force(rows) += r.force;
      tangent(rows, rows) += r.tangent;
    }
    CHECK_WITHIN(worst_entry(as_vector(force_of(g.elasticity, g.trial)), force), 1e-14);
    BlockMatrix matrix = g.matrix();
    g.elasticity.add_tangent(g.trial, matrix);
    CHECK_WITHIN(worst_entry(dense(matrix.columns(1)), tangent), 1e-14);
    const NodeField x = random.field(g.trial.positions.size(), 1.0);
    NodeField product;
    g.elasticity.multiply(x, product);
    CHECK_WITHIN(worst_entry(as_vector(product), (tangent * as_vector(x)).eval()), 1e-14);
  }
}

TEST_CASE("elasticity: the force is the gradient of the energy") {
  for (const ElementKind kind : kinds) {
    General g(kind);
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
    CHECK_WITHIN(worst_entry(force, reference), 1e-10);  // eps E / (h f), truncation (h / l)^4
    CHECK(force != reference);
  }
}

TEST_CASE("elasticity: the tangent is the derivative of the force where p = kappa (theta - 1)") {
  for (const ElementKind kind : kinds) {
    General g(kind);
    force_of(g.elasticity, g.trial);
    g.elasticity.set_pressure(g.trial.pressure);
    BlockMatrix matrix = g.matrix();
    g.elasticity.add_tangent(g.trial, matrix);
    const Eigen::MatrixXd tangent = dense(matrix.columns(1));
    Eigen::MatrixXd reference(tangent.rows(), tangent.cols());
    for (Eigen::Index k = 0; k < reference.cols(); ++k)
      reference.col(k) = derivative(
          [&](double h) -> Vector {
            Trial moved = g.trial;
            moved.positions[static_cast<std::size_t>(k)] += h;
            return as_vector(force_of(g.elasticity, moved));
          },
          5e-6);
    CHECK_WITHIN(worst_entry(tangent, reference), 1e-10);  // as above
    CHECK(tangent != reference);
  }
}

TEST_CASE("elasticity: viscous forces are linear in the velocities, and their share of the tangent says how") {
  for (const ElementKind kind : kinds) {
    General g(kind);
    const NodeField v = Random(57).field(g.trial.positions.size(), 0.1);
    g.trial.viscosity = 0.03;
    g.trial.velocities.assign(v.size(), 0.0);
    const NodeField still = force_of(g.elasticity, g.trial);
    BlockMatrix elastic = g.matrix(), both = g.matrix();
    g.elasticity.add_tangent(g.trial, elastic);
    g.trial.velocity_share = 200.0;
    g.elasticity.add_tangent(g.trial, both);
    g.trial.velocities = v;
    const Vector viscous = as_vector(force_of(g.elasticity, g.trial)) - as_vector(still);
    const Vector expected = (dense(both.columns(1)) - dense(elastic.columns(1))) * as_vector(v) / 200.0;
    CHECK_WITHIN(worst_entry(viscous, expected), 1e-11);
    CHECK(as_vector(v).dot(viscous) > 0.0);
  }
}

TEST_CASE("elasticity: viscosity takes power from every motion but rigid ones, also where the tangent is indefinite") {
  General g(ElementKind::q1p0);
  for (double& p : g.trial.pressure) p = 2e4;  // strong tension across the elements: buckling modes
  g.trial.velocity_share = 1.0;
  BlockMatrix elastic = g.matrix(), both = g.matrix();
  g.elasticity.add_tangent(g.trial, elastic);
  g.trial.viscosity = 1.0;
  g.trial.velocities.assign(g.trial.positions.size(), 0.0);
  g.elasticity.add_tangent(g.trial, both);
  const Eigen::MatrixXd viscous = dense(both.columns(1)) - dense(elastic.columns(1));
  const auto least = [](const Eigen::MatrixXd& matrix) {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix).eigenvalues()(0) / matrix.cwiseAbs().maxCoeff();
  };
  CHECK(least(dense(elastic.columns(1))) < -1e-3);
  CHECK(least(viscous) > -1e-14);
  NodeField turn(g.trial.positions.size());
  const Vector3 axis(1.0, -2.0, 0.5);
  for (Index node = 0; node < g.mesh.node_count(); ++node)
    Eigen::Map<Vector3>(turn.data() + 3 * node) = axis.cross(at(g.trial.positions, node)) + Vector3(0.1, 0.2, 0.3);
  CHECK((viscous * as_vector(turn)).norm() < 1e-12 * viscous.norm() * as_vector(turn).norm());
}

TEST_CASE("elasticity: at rest the viscosity is beta K") {
  General g(ElementKind::q1);
  g.trial.positions = g.mesh.nodes();
  g.trial.elastic_share = 1.0;
  BlockMatrix matrix = g.matrix();
  g.elasticity.add_tangent(g.trial, matrix);
  g.trial.viscosity = 0.03;
  g.trial.velocities = Random(58).field(g.trial.positions.size(), 0.1);
  const Vector expected = 0.03 * dense(matrix.columns(1)) * as_vector(g.trial.velocities);
  CHECK_WITHIN(worst_entry(as_vector(force_of(g.elasticity, g.trial)), expected), 1e-13);
}

TEST_CASE("elasticity: an offset adds to the pressure of force and tangent") {
  General g(ElementKind::q1p0);
  General plain(ElementKind::q1p0);
  g.trial.pressure_offset = Random(59).field(g.elasticity.padded_count(), 700.0);
  for (std::size_t e = 0; e < g.trial.pressure.size(); ++e) {
    g.trial.pressure[e] = 100.0;
    plain.trial.pressure[e] = 100.0 + g.trial.pressure_offset[e] / g.trial.elastic_share;
  }
  BlockMatrix with = g.matrix(), without = plain.matrix();
  g.elasticity.add_tangent(g.trial, with);
  plain.elasticity.add_tangent(plain.trial, without);
  CHECK_WITHIN(worst_entry(dense(with.columns(1)), dense(without.columns(1))), 1e-14);
  Vector expected = as_vector(force_of(plain.elasticity, plain.trial));
  for (Index e = 0; e < g.mesh.element_count(); ++e) {
    const auto k = static_cast<std::size_t>(e);
    std::vector<Index> rows;
    for (const Index node : g.mesh.hexahedra()[k]) rows.insert(rows.end(), {3 * node, 3 * node + 1, 3 * node + 2});
    const ElementResult r = reference_element(g.mesh, e, g.trial.positions, soft, {}, true);
    for (std::size_t c = 0; c < rows.size(); ++c)
      expected(rows[c]) += g.trial.pressure_offset[k] * r.volume_gradient(static_cast<Eigen::Index>(c));
  }
  CHECK_WITHIN(worst_entry(as_vector(force_of(g.elasticity, g.trial)), expected), 1e-12);
}

TEST_CASE("elasticity: predicted pressures are the linearised kappa (theta - 1)") {
  General g(ElementKind::q1p0);
  force_of(g.elasticity, g.trial);
  BlockMatrix matrix = g.matrix();
  g.elasticity.add_tangent(g.trial, matrix);
  const NodeField dx = Random(54).field(g.trial.positions.size(), 1e-3);
  std::vector<double> start(g.trial.pressure.size(), 100.0), predicted = start, half = start, now = start, rate;
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
        return as_vector(p).head(6);
      },
      1e-2);
  const Vector expected = as_vector(now).head(6) + change;
  CHECK_WITHIN(worst_entry(as_vector(predicted).head(6), expected),
               2e-12);  // rounding of theta - 1 over the difference step
  CHECK_WITHIN(worst_entry(as_vector(half).head(6), (0.5 * (expected.array() + 100.0)).matrix().eval()), 2e-12);
}

TEST_CASE("elasticity: patch test, a distorted patch under a linear map has one stress and free inner nodes") {
  const HexMesh mesh = block(3, 3, 3, 0.25);
  Matrix3 F = rotation() * (Matrix3::Identity() + Random(55).matrix(0.2));
  for (const ElementKind kind : kinds) {
    Elasticity elasticity(mesh, rest_batches(mesh), soft, kind, 1);
    Trial trial = trial_at(mapped(mesh.nodes(), F), elasticity.padded_count());
    trial.isochoric_scale.assign(elasticity.padded_count(), 2.0);
    const NodeField force = force_of(elasticity, trial);
    double inner = 0.0, outer = 0.0;
    for (Index n = 0; n < mesh.node_count(); ++n) {
      const Index i = n % 4, j = n / 4 % 4, k = n / 16;
      const bool inside = i % 3 > 0 && j % 3 > 0 && k % 3 > 0;
      double& worst = inside ? inner : outer;
      worst = std::max(worst, at(force, n).norm());
    }
    REQUIRE(outer > 1e-3);
    CHECK_WITHIN(inner / outer, 1e-13);
    const double theta = F.determinant();
    for (Index e = 0; e < mesh.element_count(); ++e)
      CHECK_WITHIN(std::abs(elasticity.dilatation()[static_cast<std::size_t>(e)] / theta - 1.0), 1e-14);
  }
}

TEST_CASE("elasticity: rest and rigid motion are free of force") {
  const HexMesh mesh = block(3, 1, 2, 0.2);
  for (const ElementKind kind : kinds) {
    Elasticity elasticity(mesh, rest_batches(mesh), tissue, kind, 1);
    const NodeField moved = mapped(mesh.nodes(), rotation(), Vector3(0.02, -0.03, 0.01));
    const NodeField reference =
        force_of(elasticity, trial_at(mapped(mesh.nodes(), 1.1 * rotation()), elasticity.padded_count()));
    const double scale = as_vector(reference).cwiseAbs().maxCoeff();
    REQUIRE(scale > 1.0);
    CHECK_WITHIN(
        as_vector(force_of(elasticity, trial_at(moved, elasticity.padded_count()))).cwiseAbs().maxCoeff() / scale,
        2e-14);
    const NodeField at_rest = force_of(elasticity, trial_at(mesh.nodes(), elasticity.padded_count()));
    CHECK_WITHIN(as_vector(at_rest).cwiseAbs().maxCoeff() / scale, 2e-14);
    CHECK_WITHIN(std::abs(elasticity.least_jacobian() - 1.0), 2e-14);
  }
}

TEST_CASE("elasticity: forces and moments of a free body balance") {
  General g(ElementKind::q1p0);
  const NodeField force = force_of(g.elasticity, g.trial);
  Vector3 total = Vector3::Zero(), moment = Vector3::Zero();
  for (Index n = 0; n < g.mesh.node_count(); ++n) {
    total += at(force, n);
    moment += at(g.trial.positions, n).cross(at(force, n));
  }
  const double scale = as_vector(force).cwiseAbs().maxCoeff();
  CHECK_WITHIN(total.norm() / scale, 2e-14);
  CHECK_WITHIN(moment.norm() / (0.03 * scale), 2e-14);
}

TEST_CASE("elasticity: an inverted element is seen and named") {
  const HexMesh mesh = block(3, 1, 2, 0.1);
  Elasticity elasticity(mesh, rest_batches(mesh), tissue, ElementKind::q1p0, 1);
  NodeField positions = mesh.nodes();
  positions[3 * 0] += 0.02;  // node 0 belongs to element 0 alone
  force_of(elasticity, trial_at(positions, elasticity.padded_count()));
  CHECK(elasticity.least_jacobian() < 0.0);
  CHECK(elasticity.worst_element() == 0);
}

TEST_CASE("elasticity: same bits for one, two and three threads") {
  const HexMesh mesh = block(10, 10, 8, 0.1);  // 200 batches: enough for three ranges
  std::vector<NodeField> forces;
  std::vector<std::vector<double>> matrices;
  for (const int threads : {1, 2, 3}) {
    Elasticity elasticity(mesh, rest_batches(mesh), tissue, ElementKind::q1p0, threads);
    const Trial trial =
        trial_at(sum(mesh.nodes(), Random(56).field(mesh.nodes().size(), 1e-3)), elasticity.padded_count());
    forces.push_back(force_of(elasticity, trial));
    BlockMatrix matrix(mesh.node_count(), bottom_held(mesh, 10, 10), mesh.hexahedra(), {}, &natural_order);
    matrix.set_mass(element_masses(mesh, 1040.0));
    elasticity.set_mass_scale(1e4);
    elasticity.add_tangent(trial, matrix);
    matrices.push_back(matrix.columns(threads).value);
  }
  CHECK(forces[1] == forces[0]);
  CHECK(forces[2] == forces[0]);
  CHECK(matrices[1] == matrices[0]);
  CHECK(matrices[2] == matrices[0]);
}

TEST_CASE("elasticity: element masses add up to the mass of the body") {
  const HexMesh mesh = block(3, 1, 2, 0.2);
  const std::vector<double> masses = element_masses(mesh, 1040.0);
  REQUIRE(masses.size() == 36 * 6);
  double total = 0.0, volume = 0.0;
  std::size_t pair = 0;
  for (Index e = 0; e < mesh.element_count(); ++e) {
    volume += mesh.volume(e);
    for (int b = 0; b < 8; ++b)
      for (int a = 0; a <= b; ++a) total += (a == b ? 1.0 : 2.0) * masses[pair++];
  }
  CHECK_WITHIN(std::abs(total / (1040.0 * volume) - 1.0), 1e-14);
}

}  // namespace glossa::test
