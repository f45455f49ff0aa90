// Tied nodes follow the pose of a rigid body exactly: x_a = c + R(theta) (X_a - C). They are eliminated, not penalised.
#pragma once

#include "bone/bone.hpp"

namespace glossa {

class RigidMotion {
 public:
  /// `rest`: node field at rest; its entry at ties.centre is the rest position of the centre.
  RigidMotion(Ties ties, const NodeField& rest);

  [[nodiscard]] const Ties& ties() const { return ties_; }
  /// Length (m) by which the rotation vector is scaled in the node field: root mean square distance of the tied nodes
  /// from the centre, so that all degrees of freedom and their forces are of one kind and size.
  [[nodiscard]] double arm() const { return arm_; }

  /// Puts the tied nodes where the pose of `positions` says.
  void place(NodeField& positions) const;
  /// Writes the increments of the tied nodes that follow, to first order, from the pose's entries of `increment`.
  void spread(const NodeField& positions, NodeField& increment) const;
  /// Adds the generalised force of the forces on the tied nodes (left as they are) to the entries of the pose.
  void pull_back(const NodeField& positions, NodeField& force) const;

  /// dx_a / d turn for each tied node, in the order of ties().nodes; dx_a / d centre is the identity.
  void turn_gradients(const NodeField& positions, std::vector<Matrix3>& gradients) const;
  /// Second derivative of the motion times the forces on the tied nodes: what the tangent gains at (turn, turn).
  [[nodiscard]] Matrix3 curvature(const NodeField& positions, const NodeField& force) const;

 private:
  [[nodiscard]] Vector3 theta(const NodeField& positions) const { return at(positions, ties_.turn) / arm_; }
  [[nodiscard]] Vector3 lever(const NodeField& positions, Index node) const {
    return at(positions, node) - at(positions, ties_.centre);
  }

  Ties ties_;
  std::vector<Vector3> rest_lever_;
  double arm_ = 1.0;
};

}  // namespace glossa
