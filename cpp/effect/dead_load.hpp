// Forces that do not depend on the state: gravity and external loads on nodes.
#pragma once

#include "effect/effect.hpp"
#include "mesh/hex_mesh.hpp"

namespace glossa {

/// Adds minus the load at every node; its potential is minus the load times the position.
class DeadLoad final : public Effect {
 public:
  DeadLoad(const char* name, NodeField load) : name_(name), load_(std::move(load)) {}

  [[nodiscard]] const char* name() const override { return name_; }
  void add_force(const Trial&, NodeField& force) override {
    for (std::size_t k = 0; k < load_.size(); ++k) force[k] -= load_[k];
  }
  void add_tangent(const Trial&, BlockMatrix&) override {}
  [[nodiscard]] double energy(const Trial& trial) const override {
    double sum = 0.0;
    for (std::size_t k = 0; k < load_.size(); ++k) sum -= load_[k] * trial.positions[k];
    return sum;
  }
  [[nodiscard]] const NodeField& load() const { return load_; }

 private:
  const char* name_;
  NodeField load_;
};

/// Weight of the body as consistent nodal forces (N) for a density (kg/m3) and a field of gravity (m/s2).
[[nodiscard]] NodeField gravity_load(const HexMesh& mesh, double density, const Vector3& gravity);
/// The same of cells with such packed consistent masses (kg), for a body of that many nodes.
[[nodiscard]] NodeField gravity_load(const Cells& cells, const std::vector<double>& masses, Index node_count,
                                     const Vector3& gravity);

}  // namespace glossa
