#include "effect/inertia.hpp"

#include "../fixture.hpp"
#include "effect/elasticity.hpp"

namespace glossa::test {

TEST_CASE("inertia: M x against the matrix of gathered masses, with a factor of the trial") {
  const HexMesh mesh = block(3, 1, 2, 0.2);
  const std::vector<double> masses = element_masses(mesh, 1040.0);
  Inertia inertia(mesh.hexahedra(), mesh.node_count(), masses);
  BlockMatrix matrix(mesh.node_count(), FreeMask(mesh.nodes().size(), 1), mesh.hexahedra(), {}, &natural_order);
  matrix.set_mass(masses);
  matrix.gather(std::vector<double>(6 * 324, 0.0), 2.5, 1);
  Trial trial;
  trial.velocities = Random(61).field(mesh.nodes().size(), 0.1);
  trial.mass_rate = 2.5;
  NodeField force(mesh.nodes().size(), 0.0);
  inertia.add_force(trial, force);
  CHECK_WITHIN(worst_entry(as_vector(force), (dense(matrix.columns(1)) * as_vector(trial.velocities)).eval()), 1e-14);
}

TEST_CASE("inertia: a translation carries the whole mass, and no mass rate no force") {
  const HexMesh mesh = block(2, 2, 2);
  Inertia inertia(mesh.hexahedra(), mesh.node_count(), element_masses(mesh, 1000.0));
  Trial trial;
  for (Index n = 0; n < mesh.node_count(); ++n) trial.velocities.insert(trial.velocities.end(), {1.0, 0.0, -2.0});
  NodeField force(mesh.nodes().size(), 0.0);
  inertia.add_force(trial, force);
  CHECK(as_vector(force).isZero(0.0));
  inertia.multiply(1.0, trial.velocities, force);
  Vector3 total = Vector3::Zero();
  for (Index n = 0; n < mesh.node_count(); ++n) total += at(force, n);
  CHECK_WITHIN((total - 8e-3 * Vector3(1, 0, -2)).norm(), 1e-16);  // 8 cm3 of water
}

TEST_CASE("inertia: point masses add to the mass at their nodes, in the effect as in the matrix") {
  const HexMesh mesh = block(2, 1, 1, 0.2, 0.01, 1);
  const std::vector<double> masses = element_masses(mesh, 1040.0);
  const std::vector<PointMass> points{{4, 0.02}, {4, 0.01}, {9, 0.005}, {12, 0.7}};  // 12 is an outside point
  Inertia with(mesh.hexahedra(), mesh.node_count(), masses, points),
      without(mesh.hexahedra(), mesh.node_count(), masses);
  const NodeField x = Random(62).field(mesh.nodes().size(), 0.1);
  NodeField product(x.size(), 0.0), tissue(x.size(), 0.0);
  with.multiply(2.0, x, product);
  without.multiply(2.0, x, tissue);
  NodeField expected(x.size(), 0.0);
  for (const PointMass& point : points)
    Eigen::Map<Vector3>(expected.data() + 3 * point.node) += 2.0 * point.mass * at(x, point.node);
  CHECK_WITHIN(worst_entry(sum(product, tissue, -1.0), expected), 1e-15);

  BlockMatrix matrix(mesh.node_count(), FreeMask(mesh.nodes().size(), 1), mesh.hexahedra(), {}, &natural_order);
  matrix.set_mass(masses);
  for (const PointMass& point : points) matrix.add_mass(point.node, point.mass);
  matrix.gather(std::vector<double>(2 * 324, 0.0), 2.0, 1);
  CHECK_WITHIN(worst_entry(as_vector(product).head(36), (dense(matrix.columns(1)) * as_vector(x).head(36)).eval()),
               1e-14);
}

}  // namespace glossa::test
