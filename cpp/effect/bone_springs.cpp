#include "effect/bone_springs.hpp"

namespace glossa {
namespace {

struct Stretch {
  Vector3 direction;  // from the fixed point to the bone; zero if they coincide
  double length;
  double tension;  // N
};

Stretch stretch(const BoneSpring& spring, const NodeField& positions) {
  const Vector3 d = at(positions, spring.on_bone) - at(positions, spring.fixed);
  const double length = d.norm();
  return {length > 0.0 ? Vector3(d / length) : Vector3(Vector3::Zero()), length,
          spring.stiffness * (length - spring.rest_length)};
}

Matrix3 tangent(const BoneSpring& spring, const NodeField& positions) {
  const Stretch s = stretch(spring, positions);
  const Matrix3 along = s.direction * s.direction.transpose();
  if (s.length == 0.0) return Matrix3::Zero();
  return spring.stiffness * along + s.tension / s.length * (Matrix3::Identity() - along);
}

}  // namespace

void BoneSprings::add_force(const Trial& trial, NodeField& force) {
  for (const BoneSpring& spring : springs_) {
    const Stretch s = stretch(spring, trial.positions);
    const Vector3 pull = s.tension * s.direction;
    Eigen::Map<Vector3>(force.data() + 3 * spring.on_bone) += pull;
    Eigen::Map<Vector3>(force.data() + 3 * spring.fixed) -= pull;
  }
}

void BoneSprings::add_tangent(const Trial& trial, BlockMatrix& matrix) {
  for (const BoneSpring& spring : springs_)
    matrix.add(spring.on_bone, spring.on_bone, tangent(spring, trial.positions));
}

double BoneSprings::energy(const Trial& trial) const {
  double sum = 0.0;
  for (const BoneSpring& spring : springs_) {
    const double excess = stretch(spring, trial.positions).length - spring.rest_length;
    sum += 0.5 * spring.stiffness * excess * excess;
  }
  return sum;
}

void BoneSprings::multiply(const Trial& trial, const NodeField& x, NodeField& product) const {
  for (const BoneSpring& spring : springs_) {
    const Vector3 pull = tangent(spring, trial.positions) * (at(x, spring.on_bone) - at(x, spring.fixed));
    Eigen::Map<Vector3>(product.data() + 3 * spring.on_bone) += pull;
    Eigen::Map<Vector3>(product.data() + 3 * spring.fixed) -= pull;
  }
}

}  // namespace glossa
