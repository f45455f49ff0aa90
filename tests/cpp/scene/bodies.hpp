// Small scenes for the tests.
#pragma once

#include <limits>

#include "../muscle/fibres.hpp"
#include "scene/equilibrium.hpp"
#include "scene/simulation.hpp"
#include "scene/solver.hpp"

namespace glossa::test {

constexpr double silent = std::numeric_limits<double>::quiet_NaN();

/// Tissue, upright gravity and a held bottom face for a block of nx x ny x nz cells; no muscle.
inline SceneOptions passive(const HexMesh& mesh, Index nx, Index ny) {
  SceneOptions options;
  options.free = bottom_held(mesh, nx, ny);
  options.gravity = Vector3(0.0, 0.0, -9.81);
  return options;
}

/// The same with the three muscles of three_fibres() in a block of 2 x 2 x 2 cells.
inline SceneOptions muscular(const HexMesh& mesh) {
  SceneOptions options = passive(mesh, 2, 2);
  options.fibres = three_fibres(mesh);
  for (double& capacity : options.fibres.capacity) capacity *= 0.2;
  options.muscle_count = 3;
  return options;
}

/// No command at any time.
inline CommandTable no_commands(Index muscles = 0) {
  return {{0.0}, std::vector<double>(static_cast<std::size_t>(muscles), silent), muscles};
}

inline Equilibrium settle(Solver& solver, const std::vector<double>& fractions = {},
                          const EquilibriumOptions& options = {}) {
  std::vector<bool> commanded;
  for (const double fraction : fractions) commanded.push_back(!std::isnan(fraction));
  System& system = *solver.system(solver.scene().options().free, commanded);
  if (!fractions.empty()) system.set_command(fractions);
  const NodeField& rest = solver.scene().mesh().nodes();
  return equilibrate(system, rest, {}, rest, options);
}

inline double volume_of(const HexMesh& mesh) {
  double volume = 0.0;
  for (Index e = 0; e < mesh.element_count(); ++e) volume += mesh.volume(e);
  return volume;
}

/// Largest distance between two fields, node by node and component by component.
inline double distance(const NodeField& a, const NodeField& b) {
  return (as_vector(a) - as_vector(b)).cwiseAbs().maxCoeff();
}

}  // namespace glossa::test
