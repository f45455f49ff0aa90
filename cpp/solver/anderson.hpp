// Anderson acceleration with a frozen factor: a quasi-Newton method that costs one residual and one solve each time.
#pragma once

#include <deque>

#include "core/types.hpp"

namespace glossa {

/// Solves G(u) = 0 from iterates of the preconditioned fixed point u <- u + F, F = -P^(-1) G, with P symmetric
/// positive definite (a factor from an earlier state). The step is u += F - (dU + dF) gamma with gamma the
/// least-squares fit of F by the last differences dF in the metric of P, for which (dF' dG) gamma = dF' G needs no
/// product with P (Anderson 1965; Fang & Saad 2009).
class Anderson {
 public:
  explicit Anderson(std::size_t memory = 8) : memory_(memory) {}
  /// Forgets the past: the factor or the equation has changed.
  void reset();
  /// The increment of u, from the residual G(u) and F = -P^(-1) G(u) at the present iterate. `u` must be the iterate.
  [[nodiscard]] Vector increment(const Vector& u, const Vector& F, const Vector& G);

 private:
  struct Difference {
    Vector u, F, G;
  };
  void remember(Difference difference);

  std::size_t memory_;
  std::deque<Difference> differences_;
  Eigen::MatrixXd products_;  // dF' dG of all pairs of differences
  Vector u_, F_, G_;
  bool has_last_ = false;
};

}  // namespace glossa
