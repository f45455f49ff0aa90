#include "effect/muscle_force.hpp"

#include "muscle/reflex.hpp"

namespace glossa {

MuscleForce::MuscleForce(const Macrofibres& fibres, const ForceLaw& law) : fibres_(fibres), law_(law) {
  const auto count = static_cast<std::size_t>(fibres.count());
  lambda_.assign(count, 0.0);
  length_.assign(count, 0.0);
  rate_.assign(count, 0.0);
  tension_.assign(count, 0.0);
}

void MuscleForce::bind(const BlockMatrix& matrix, bool stretch) {
  stretch_ = stretch;
  slot_start_.assign(1, 0);
  slots_.clear();
  for (Index f = 0; f < fibres_.count(); ++f) {
    const Index* path = fibres_.nodes.begin(f);
    for (Index b = 0; b < fibres_.nodes.length(f); ++b)
      for (Index a = first_coupled(b); a <= b; ++a) slots_.push_back(matrix.slot(path[a], path[b]));
    slot_start_.push_back(static_cast<Index>(slots_.size()));
  }
}

void MuscleForce::measure(Trial& trial) {
  trial.activation.resize(length_.size());
  const bool rates = law_.force_velocity || trial.rate_gain > 0.0;
  for (Index f = 0; f < fibres_.count(); ++f) {
    const auto k = static_cast<std::size_t>(f);
    length_[k] = fibre_length(fibres_, f, trial.positions);
    rate_[k] = rates && trial.velocity_share > 0.0 ? fibre_rate(fibres_, f, trial.positions, trial.velocities) : 0.0;
    if (trial.activation_follows)
      trial.activation[k] = Reflex{0.0, trial.rate_gain}.activation(length_[k], lambda_[k], rate_[k]);
  }
}

void MuscleForce::add_force(const Trial& trial, NodeField& force) {
  for (Index f = 0; f < fibres_.count(); ++f) {
    const auto k = static_cast<std::size_t>(f);
    tension_[k] = fibres_.capacity[k] * law_.level(trial.activation[k]);
    if (tension_[k] == 0.0) continue;
    tension_[k] *= law_.velocity_factor(rate_[k] / fibres_.rest_length[k]);
    const Index* path = fibres_.nodes.begin(f);
    for (Index s = 0; s + 1 < fibres_.nodes.length(f); ++s) {
      const Vector3 pull = tension_[k] * fibre_segment(fibres_, f, s, trial.positions).direction;
      Eigen::Map<Vector3>(force.data() + 3 * path[s]) -= pull;
      Eigen::Map<Vector3>(force.data() + 3 * path[s + 1]) += pull;
    }
  }
}

// dT / d(length of the polyline), through the length (where it is felt at once) and through the rate.
double MuscleForce::axial_stiffness(const Trial& trial, std::size_t k) const {
  const double a = trial.activation[k];
  if (a <= 0.0) return 0.0;
  const double v = rate_[k] / fibres_.rest_length[k];
  double slope =
      fibres_.capacity[k] * law_.level(a) * law_.velocity_slope(v) / fibres_.rest_length[k] * trial.velocity_share;
  if (trial.activation_follows)
    slope += fibres_.capacity[k] * law_.level_slope(a) * law_.velocity_factor(v) *
             (1.0 + trial.rate_gain * trial.velocity_share);
  return slope * fibres_.length_factor[k];
}

void MuscleForce::add_tangent(const Trial& trial, BlockMatrix& matrix) {
  for (Index f = 0; f < fibres_.count(); ++f) {
    const auto k = static_cast<std::size_t>(f);
    if (trial.activation[k] <= 0.0) continue;
    const double axial = stretch_ ? axial_stiffness(trial, k) : 0.0;
    const Index count = fibres_.nodes.length(f);
    fibre_gradient(fibres_, f, trial.positions, gradient_);
    bend_.resize(static_cast<std::size_t>(count));
    for (Index s = 0; s + 1 < count; ++s)
      bend_[static_cast<std::size_t>(s)] = tension_[k] * fibre_segment(fibres_, f, s, trial.positions).curvature();
    const BlockMatrix::Slot* slot = slots_.data() + slot_start_[k];
    for (Index b = 0; b < count; ++b)
      for (Index a = first_coupled(b); a <= b; ++a, ++slot) {
        Matrix3 block =
            axial * gradient_[static_cast<std::size_t>(a)] * gradient_[static_cast<std::size_t>(b)].transpose();
        if (a + 1 == b) block -= bend_[static_cast<std::size_t>(a)];
        if (a == b && b > 0) block += bend_[static_cast<std::size_t>(b) - 1];
        if (a == b && b + 1 < count) block += bend_[static_cast<std::size_t>(b)];
        matrix.add(*slot, block);
      }
  }
}

double MuscleForce::stretch(const Trial& trial, Index fibre, std::vector<Vector3>& gradient) const {
  const double axial = axial_stiffness(trial, static_cast<std::size_t>(fibre));
  if (axial != 0.0) fibre_gradient(fibres_, fibre, trial.positions, gradient);
  return axial;
}

double MuscleForce::energy(const Trial& trial) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < tension_.size(); ++k)
    sum += fibres_.capacity[k] * law_.level_integral(trial.activation[k]) * law_.velocity_factor(0.0) /
           fibres_.length_factor[k];
  return sum;
}

void MuscleForce::multiply(const Trial& trial, const NodeField& x, NodeField& product) const {
  std::vector<Vector3> gradient;
  for (Index f = 0; f < fibres_.count(); ++f) {
    const auto k = static_cast<std::size_t>(f);
    if (trial.activation[k] <= 0.0) continue;
    const Index* path = fibres_.nodes.begin(f);
    fibre_gradient(fibres_, f, trial.positions, gradient);
    double stretch = 0.0;
    for (std::size_t a = 0; a < gradient.size(); ++a) stretch += gradient[a].dot(at(x, path[a]));
    const double axial = axial_stiffness(trial, k) * stretch;
    for (std::size_t a = 0; a < gradient.size(); ++a)
      Eigen::Map<Vector3>(product.data() + 3 * path[a]) += axial * gradient[a];
    for (std::size_t a = 0; a + 1 < gradient.size(); ++a) {
      const Vector3 turn = tension_[k] * fibre_segment(fibres_, f, static_cast<Index>(a), trial.positions).curvature() *
                           (at(x, path[a + 1]) - at(x, path[a]));
      Eigen::Map<Vector3>(product.data() + 3 * path[a]) -= turn;
      Eigen::Map<Vector3>(product.data() + 3 * path[a + 1]) += turn;
    }
  }
}

}  // namespace glossa
