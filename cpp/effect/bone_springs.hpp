// The springs that hold the hyoid bone: "six springs per side of 220 N/m" of Buchaillard, Perrier & Payan 2009, II.B.
#pragma once

#include "bone/bone.hpp"
#include "effect/effect.hpp"

namespace glossa {

/// Linear springs between points of the bone and fixed points; energy k (l - l0)^2 / 2 each. They are not damped.
class BoneSprings final : public Effect {
 public:
  explicit BoneSprings(const std::vector<BoneSpring>& springs) : springs_(springs) {}

  [[nodiscard]] const char* name() const override { return "hyoid"; }
  void add_force(const Trial& trial, NodeField& force) override;
  void add_tangent(const Trial& trial, BlockMatrix& matrix) override;
  [[nodiscard]] double energy(const Trial& trial) const override;
  /// K x, added to `product`.
  void multiply(const Trial& trial, const NodeField& x, NodeField& product) const;

 private:
  const std::vector<BoneSpring>& springs_;
};

}  // namespace glossa
