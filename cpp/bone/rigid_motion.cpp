#include "bone/rigid_motion.hpp"

#include "bone/rotation.hpp"

namespace glossa {

RigidMotion::RigidMotion(Ties ties, const NodeField& rest) : ties_(std::move(ties)) {
  const Vector3 centre = at(rest, ties_.centre);
  double sum = 0.0;
  for (const Index node : ties_.nodes) {
    rest_lever_.push_back(at(rest, node) - centre);
    sum += rest_lever_.back().squaredNorm();
  }
  if (sum > 0.0) arm_ = std::sqrt(sum / static_cast<double>(rest_lever_.size()));
}

void RigidMotion::place(NodeField& positions) const {
  const Matrix3 rotation = rotation_matrix(theta(positions));
  const Vector3 centre = at(positions, ties_.centre);
  for (std::size_t k = 0; k < ties_.nodes.size(); ++k)
    Eigen::Map<Vector3>(positions.data() + 3 * ties_.nodes[k]) = centre + rotation * rest_lever_[k];
}

void RigidMotion::spread(const NodeField& positions, NodeField& increment) const {
  const Vector3 turned = rotation_jacobian(theta(positions)) * at(increment, ties_.turn) / arm_;
  const Vector3 moved = at(increment, ties_.centre);
  for (const Index node : ties_.nodes)
    Eigen::Map<Vector3>(increment.data() + 3 * node) = moved + turned.cross(lever(positions, node));
}

void RigidMotion::pull_back(const NodeField& positions, NodeField& force) const {
  Vector3 sum = Vector3::Zero(), moment = Vector3::Zero();
  for (const Index node : ties_.nodes) {
    sum += at(force, node);
    moment += lever(positions, node).cross(at(force, node));
  }
  Eigen::Map<Vector3>(force.data() + 3 * ties_.centre) += sum;
  Eigen::Map<Vector3>(force.data() + 3 * ties_.turn) += rotation_jacobian(theta(positions)).transpose() * moment / arm_;
}

void RigidMotion::turn_gradients(const NodeField& positions, std::vector<Matrix3>& gradients) const {
  const Matrix3 jacobian = rotation_jacobian(theta(positions)) / arm_;
  gradients.resize(ties_.nodes.size());
  for (std::size_t k = 0; k < gradients.size(); ++k)
    gradients[k] = -cross_matrix(lever(positions, ties_.nodes[k])) * jacobian;
}

Matrix3 RigidMotion::curvature(const NodeField& positions, const NodeField& force) const {
  Matrix3 lever_force = Matrix3::Zero();
  Vector3 moment = Vector3::Zero();
  for (const Index node : ties_.nodes) {
    const Vector3 r = lever(positions, node), f = at(force, node);
    lever_force += r * f.transpose() - r.dot(f) * Matrix3::Identity();
    moment += r.cross(f);
  }
  const Matrix3 jacobian = rotation_jacobian(theta(positions));
  const Matrix3 whole = jacobian.transpose() * lever_force * jacobian + pulled_moment_slope(theta(positions), moment);
  return 0.5 * (whole + whole.transpose()) / (arm_ * arm_);
}

}  // namespace glossa
