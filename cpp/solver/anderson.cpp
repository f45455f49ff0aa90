#include "solver/anderson.hpp"

#include <Eigen/QR>

#include <cmath>

namespace glossa {

void Anderson::reset() {
  differences_.clear();
  has_last_ = false;
}

void Anderson::remember(Difference difference) {
  const auto most = static_cast<Eigen::Index>(memory_);
  if (products_.rows() != most) products_ = Eigen::MatrixXd::Zero(most, most);
  if (differences_.size() == memory_) {
    differences_.pop_front();
    products_.topLeftCorner(most - 1, most - 1) = products_.bottomRightCorner(most - 1, most - 1).eval();
  }
  const auto last = static_cast<Eigen::Index>(differences_.size());
  differences_.push_back(std::move(difference));
  const Difference& d = differences_.back();
  for (Eigen::Index j = 0; j <= last; ++j) {
    const Difference& other = differences_[static_cast<std::size_t>(j)];
    products_(j, last) = other.F.dot(d.G);
    products_(last, j) = d.F.dot(other.G);
  }
}

Vector Anderson::increment(const Vector& u, const Vector& F, const Vector& G) {
  if (has_last_) remember({u - u_, F - F_, G - G_});
  u_ = u;
  F_ = F;
  G_ = G;
  has_last_ = true;
  const auto m = static_cast<Eigen::Index>(differences_.size());
  if (m == 0) return F;
  const Eigen::MatrixXd normal = products_.topLeftCorner(m, m);
  Vector right(m);
  for (Eigen::Index i = 0; i < m; ++i) right(i) = differences_[static_cast<std::size_t>(i)].F.dot(G);
  // Differences shrink as the iteration converges: they are scaled to one size before nearly parallel ones are cut.
  const Vector size = normal.diagonal().cwiseAbs().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
  decomposition.setThreshold(1e-12);
  decomposition.compute(size.asDiagonal() * normal * size.asDiagonal());
  const Vector gamma = size.asDiagonal() * decomposition.solve(size.asDiagonal() * right);
  Vector step = F;
  for (Eigen::Index j = 0; j < m; ++j) {
    const Difference& d = differences_[static_cast<std::size_t>(j)];
    step -= gamma(j) * (d.u + d.F);
  }
  return step;
}

}  // namespace glossa
