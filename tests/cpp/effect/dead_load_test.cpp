#include "effect/dead_load.hpp"

#include "../fixture.hpp"
#include "effect/elasticity.hpp"
#include "effect/inertia.hpp"

namespace glossa::test {

TEST_CASE("gravity: nodal loads add up to the weight, and each node carries its share of the consistent mass") {
  const HexMesh mesh = block(3, 2, 1, 0.2, 0.01, 1);
  const Vector3 g(0.3, -1.0, -9.81);
  const NodeField load = gravity_load(mesh, 1040.0, g);
  double volume = 0.0;
  for (Index e = 0; e < mesh.element_count(); ++e) volume += mesh.volume(e);
  Vector3 total = Vector3::Zero();
  for (Index n = 0; n < mesh.node_count(); ++n) total += at(load, n);
  CHECK_WITHIN((total - 1040.0 * volume * g).norm() / total.norm(), 1e-14);
  CHECK(at(load, mesh.node_count() - 1).isZero(0.0));  // the outside point
  NodeField acceleration, share(load.size(), 0.0);
  for (Index n = 0; n < mesh.node_count(); ++n) acceleration.insert(acceleration.end(), g.begin(), g.end());
  Inertia(mesh.hexahedra(), mesh.node_count(), element_masses(mesh, 1040.0)).multiply(1.0, acceleration, share);
  CHECK_WITHIN(worst_entry(load, share), 1e-14);
}

TEST_CASE("gravity: a regular block shares its weight 1 : 2 : 4 among corner, edge and face") {
  const HexMesh mesh = block(2, 2, 1);
  const NodeField load = gravity_load(mesh, 1000.0, Vector3(0, 0, -8.0));
  CHECK_WITHIN(std::abs(load[3 * 0 + 2] + 1e-3), 1e-17);  // 8 mN per cell
  CHECK_WITHIN(std::abs(load[3 * 1 + 2] + 2e-3), 1e-17);
  CHECK_WITHIN(std::abs(load[3 * 4 + 2] + 4e-3), 1e-17);
}

TEST_CASE("dead load: adds minus the load; the energy is minus load times position") {
  const NodeField load{1.0, -2.0, 3.0};
  DeadLoad effect("loads", load);
  NodeField force{10.0, 10.0, 10.0};
  Trial trial;
  trial.positions = {0.5, 0.25, 2.0};
  effect.add_force(trial, force);
  CHECK(force == NodeField{9.0, 12.0, 7.0});
  CHECK(effect.energy(trial) == -6.0);
}

}  // namespace glossa::test
