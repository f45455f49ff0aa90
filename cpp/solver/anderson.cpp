#include "solver/anderson.hpp"

#include <Eigen/QR>

namespace glossa {

void Anderson::reset() {
  differences_.clear();
  has_last_ = false;
}

Vector Anderson::increment(const Vector& u, const Vector& F, const Vector& G) {
  if (has_last_) {
    differences_.push_back({u - u_, F - F_, G - G_});
    if (differences_.size() > memory_) differences_.pop_front();
  }
  u_ = u;
  F_ = F;
  G_ = G;
  has_last_ = true;
  const auto m = static_cast<Eigen::Index>(differences_.size());
  if (m == 0) return F;
  Eigen::MatrixXd normal(m, m);
  Vector right(m);
  for (Eigen::Index i = 0; i < m; ++i) {
    const Vector& dF = differences_[static_cast<std::size_t>(i)].F;
    for (Eigen::Index j = 0; j < m; ++j) normal(i, j) = dF.dot(differences_[static_cast<std::size_t>(j)].G);
    right(i) = dF.dot(G);
  }
  // Rank-revealing: nearly parallel differences must not blow up the step.
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(normal);
  qr.setThreshold(1e-10);
  const Vector gamma = qr.solve(right);
  Vector step = F;
  for (Eigen::Index j = 0; j < m; ++j) {
    const Difference& d = differences_[static_cast<std::size_t>(j)];
    step -= gamma(j) * (d.u + d.F);
  }
  return step;
}

}  // namespace glossa
