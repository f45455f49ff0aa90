#include "effect/bone_springs.hpp"

#include "../fixture.hpp"

namespace glossa::test {
namespace {

/// Springs between corners of a hexahedron (0 .. 7) and outside points (8, 9): one in tension, one in compression, one
/// without rest length, two at one node.
struct Springs {
  HexMesh mesh = block(1, 1, 1, 0.1, 0.01, 2);
  std::vector<BoneSpring> springs{{0, 8, 220.0, 0.01}, {7, 8, 150.0, 0.08}, {3, 9, 300.0, 0.0}, {7, 9, 90.0, 0.02}};
  BoneSprings effect{springs};
  Trial trial;

  Springs() { trial.positions = sum(mesh.nodes(), Random(241).field(mesh.nodes().size(), 2e-3)); }
  [[nodiscard]] Vector force(const NodeField& positions) {
    Trial moved;
    moved.positions = positions;
    NodeField result(positions.size(), 0.0);
    effect.add_force(moved, result);
    return as_vector(result);
  }
  [[nodiscard]] double energy(const NodeField& positions) const {
    Trial moved;
    moved.positions = positions;
    return effect.energy(moved);
  }
  [[nodiscard]] NodeField moved(Eigen::Index component, double h) const {
    NodeField result = trial.positions;
    result[static_cast<std::size_t>(component)] += h;
    return result;
  }
};

}  // namespace

TEST_CASE("bone springs: force k (l - l0) along the spring, equal and opposite at its ends") {
  Springs s;
  s.springs = {{7, 8, 150.0, 0.08}};
  const Vector force = s.force(s.trial.positions);
  const Vector3 d = at(s.trial.positions, 7) - at(s.trial.positions, 8);
  REQUIRE(d.norm() < 0.08);  // compressed: the bone resists by pushing away
  const Vector3 expected = 150.0 * (d.norm() - 0.08) * d.normalized();
  CHECK_WITHIN((force.segment<3>(21) - expected).norm() / expected.norm(), 1e-15);
  CHECK(force.segment<3>(24) == -force.segment<3>(21));
  CHECK_WITHIN(std::abs(s.energy(s.trial.positions) / (75.0 * std::pow(d.norm() - 0.08, 2)) - 1.0), 1e-14);
}

TEST_CASE("bone springs: the force is the gradient of the energy") {
  Springs s;
  const Vector force = s.force(s.trial.positions);
  Vector gradient(force.size());
  for (Eigen::Index k = 0; k < force.size(); ++k)
    gradient(k) = slope([&](double h) { return s.energy(s.moved(k, h)); }, 1e-5);
  CHECK_WITHIN(worst_entry(force, gradient), 5e-11);  // truncation (h / l)^4, rounding eps E / (h f)
}

TEST_CASE("bone springs: the tangent at the bone, and K x with both ends moving, are derivatives of the force") {
  Springs s;
  const FreeMask free(30, 1);
  BlockMatrix matrix(10, free, s.mesh.hexahedra(), {}, &natural_order);
  matrix.gather(std::vector<double>(324, 0.0), 0.0, 1);
  s.effect.add_tangent(s.trial, matrix);
  Eigen::MatrixXd reference(30, 30);
  for (Eigen::Index k = 0; k < 30; ++k)
    reference.col(k) = derivative([&](double h) { return s.force(s.moved(k, h)); }, 1e-5);
  CHECK_WITHIN(worst_entry(dense(matrix.columns(1)), reference.topLeftCorner(24, 24).eval()), 5e-11);
  const NodeField x = Random(242).field(30, 1.0);
  NodeField product(30, 0.0);
  s.effect.multiply(s.trial, x, product);
  CHECK_WITHIN(worst_entry(as_vector(product), (reference * as_vector(x)).eval()), 5e-11);
}

TEST_CASE("bone springs: ends that coincide give no force and no tangent, not NaN") {
  Springs s;
  s.springs = {{7, 8, 150.0, 0.08}};
  Eigen::Map<Vector3>(s.trial.positions.data() + 21) = at(s.trial.positions, 8);
  CHECK(s.force(s.trial.positions).isZero(0.0));
  NodeField product(30, 0.0);
  s.effect.multiply(s.trial, Random(243).field(30, 1.0), product);
  CHECK(as_vector(product).isZero(0.0));
}

}  // namespace glossa::test
