#include "bone/rigid_motion.hpp"

#include "../fixture.hpp"
#include "bone/rotation.hpp"

namespace glossa::test {
namespace {

/// Ten nodes in general position; 1, 3, 4 and 8 are tied, the pose stands at 6 (centre) and 9 (turn).
struct Body {
  NodeField rest = Random(211).field(30, 0.02);
  Ties ties{{1, 3, 4, 8}, 6, 9};
  RigidMotion motion = started();

  RigidMotion started() {
    std::fill_n(rest.begin() + 27, 3, 0.0);
    return {ties, rest};
  }
  /// Positions in a general pose: moved, and turned by `angle` (rad).
  [[nodiscard]] NodeField posed(double angle, std::uint64_t seed = 212) const {
    Random random(seed);
    NodeField positions = sum(rest, random.field(30, 0.01));
    const Vector3 axis = random.matrix(1.0).col(0).normalized();
    Eigen::Map<Vector3>(positions.data() + 27) = angle * motion.arm() * axis;
    motion.place(positions);
    return positions;
  }
};

const std::vector<double> angles{0.0, 1e-7, 0.05, 0.4, 2.5};

/// Entries of the pose: centre, turn.
Vector pose_of(const NodeField& field) {
  return (Vector(6) << at(field, 6), at(field, 9)).finished();
}

void add_to_pose(const Vector& change, NodeField& field) {
  for (std::size_t i = 0; i < 3; ++i) {
    field[18 + i] += change(static_cast<Eigen::Index>(i));
    field[27 + i] += change(static_cast<Eigen::Index>(3 + i));
  }
}

}  // namespace

TEST_CASE("rigid motion: tied nodes keep their distances and follow rotation and centre; others stay") {
  const Body body;
  double squares = 0.0;
  for (const Index n : body.ties.nodes) squares += (at(body.rest, n) - at(body.rest, 6)).squaredNorm() / 4.0;
  CHECK_WITHIN(std::abs(body.motion.arm() / std::sqrt(squares) - 1.0), 1e-15);
  NodeField still = body.rest;
  body.motion.place(still);
  CHECK_WITHIN((as_vector(still) - as_vector(body.rest)).norm(), 1e-17);
  for (const double angle : angles) {
    const NodeField positions = body.posed(angle);
    NodeField again = positions;
    body.motion.place(again);
    CHECK(again == positions);
    const Matrix3 R = rotation_matrix(at(positions, 9) / body.motion.arm());
    CHECK_WITHIN(std::abs(std::acos(std::clamp(0.5 * (R.trace() - 1.0), -1.0, 1.0)) - angle), 2e-8);  // acos near 1
    for (const Index n : body.ties.nodes) {
      const Vector3 lever = at(body.rest, n) - at(body.rest, 6);
      CHECK_WITHIN((at(positions, n) - at(positions, 6) - R * lever).norm(), 1e-17);
      for (const Index m : body.ties.nodes)
        CHECK_WITHIN(
            std::abs((at(positions, n) - at(positions, m)).norm() - (at(body.rest, n) - at(body.rest, m)).norm()),
            5e-17);  // rounding
    }
  }
}

TEST_CASE("rigid motion: a bone of one point at its centre has an arm of 1 m") {
  const NodeField rest{0.1, 0.2, 0.3, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0};
  CHECK(RigidMotion({{0}, 1, 2}, rest).arm() == 1.0);
}

TEST_CASE("rigid motion: increments are the derivative of the motion") {
  const Body body;
  for (const double angle : angles) {
    const NodeField positions = body.posed(angle);
    const Vector change = as_vector(Random(213).field(6, 1.0));
    NodeField increment(30, 0.0);
    add_to_pose(change, increment);
    body.motion.spread(positions, increment);
    CHECK(pose_of(increment) == change);
    std::vector<Matrix3> gradients;
    body.motion.turn_gradients(positions, gradients);
    REQUIRE(gradients.size() == 4);
    for (std::size_t k = 0; k < 4; ++k) {
      const Index n = body.ties.nodes[k];
      const Vector3 reference = derivative(
          [&](double h) {
            NodeField moved = positions;
            add_to_pose(h * change, moved);
            body.motion.place(moved);
            return at(moved, n);
          },
          1e-5);
      CHECK(reference.norm() > 0.1);
      CHECK_WITHIN((at(increment, n) - reference).norm(), 1e-10);  // truncation (h / arm)^4, rounding eps x / h
      CHECK_WITHIN((change.head(3) + gradients[k] * change.tail(3) - at(increment, n)).norm(), 1e-15);
    }
    for (const Index n : {0, 2, 5, 7}) CHECK(at(increment, n).isZero(0.0));
  }
}

TEST_CASE("rigid motion: the force on the pose is the transpose of the increments") {
  const Body body;
  for (const double angle : angles) {
    const NodeField positions = body.posed(angle);
    const NodeField force = Random(214).field(30, 2.0);
    NodeField reduced = force;
    body.motion.pull_back(positions, reduced);
    for (Index n = 0; n < 9; ++n)
      if (n != 6) CHECK(at(reduced, n) == at(force, n));
    const Vector gained = pose_of(reduced) - pose_of(force);
    Vector expected(6);
    for (Eigen::Index k = 0; k < 6; ++k) {
      NodeField increment(30, 0.0);
      add_to_pose(Vector::Unit(6, k), increment);
      body.motion.spread(positions, increment);
      expected(k) = 0.0;
      for (const Index n : body.ties.nodes) expected(k) += at(increment, n).dot(at(force, n));
    }
    CHECK_WITHIN(worst_entry(gained, expected), 1e-15);
  }
}

TEST_CASE("rigid motion: curvature is the derivative of the force on the pose, forces on the nodes held") {
  const Body body;
  for (const double angle : angles) {
    const NodeField positions = body.posed(angle);
    const NodeField force = Random(215).field(30, 2.0);
    const auto on_pose = [&](const Vector& change) {
      NodeField moved = positions, reduced = force;
      add_to_pose(change, moved);
      body.motion.place(moved);
      body.motion.pull_back(moved, reduced);
      return pose_of(reduced);
    };
    Eigen::MatrixXd whole(6, 6);
    for (Eigen::Index k = 0; k < 6; ++k)
      whole.col(k) = derivative([&](double h) { return on_pose(h * Vector::Unit(6, k)); }, 1e-5);
    const Matrix3 curvature = body.motion.curvature(positions, force);
    CHECK_WITHIN(worst_entry(curvature, whole.bottomRightCorner(3, 3).eval()), 1e-10);  // rounding eps / (h / arm)
    CHECK_WITHIN(whole.topRows(3).norm() / whole.norm(), 1e-10);  // a shift of the centre keeps every moment
    CHECK_WITHIN(whole.leftCols(3).norm() / whole.norm(), 1e-10);
    CHECK(curvature == curvature.transpose());
  }
}

}  // namespace glossa::test
