#include "contact/contact_law.hpp"

#include "../fixture.hpp"

namespace glossa::test {
namespace {

constexpr ContactLaw law{4e8, 5e-5, 3e8, 0.2};

}  // namespace

TEST_CASE("contact law: pressure never pulls, starts with the stiffness and grows ever faster near the deepest") {
  CHECK(law.pressure(-1e-5) == 0.0);
  CHECK(law.pressure(0.0) == 0.0);
  CHECK_WITHIN(std::abs(law.pressure(1e-10) / (4e8 * 1e-10) - 1.0), 1e-5);
  CHECK_WITHIN(std::abs(law.pressure(2.5e-5) / (2.0 * 4e8 * 2.5e-5) - 1.0), 1e-15);
  CHECK_WITHIN(std::abs(law.pressure(4e-5) / (5.0 * 4e8 * 4e-5) - 1.0), 1e-14);
  CHECK_WITHIN(std::abs(law.pressure(5e-5) / (5.0 * 4e8 * 4e-5 + 25.0 * 4e8 * 1e-5) - 1.0), 1e-14);
  for (double depth = 1e-6; depth < 1e-4; depth += 1e-6) CHECK(law.pressure(depth) > law.pressure(depth - 1e-6));
}

TEST_CASE("contact law: pressure is the slope of the energy, its slope that of the pressure") {
  for (const double depth : {-3e-5, -1e-6, 1e-6, 1e-5, 2.5e-5, 3.9e-5, 4.1e-5, 2e-4}) {
    CAPTURE(depth);
    const double step = depth < 3e-5 || depth > 1e-4 ? 1e-7 : 1e-8;  // on one side of 40 um
    const double energy = slope([&](double h) { return law.energy(depth + h); }, step);
    CHECK_WITHIN(std::abs(energy - law.pressure(depth)), 1e-5 * (1.0 + law.pressure(depth)));
    const double pressure = slope([&](double h) { return law.pressure(depth + h); }, step);
    CHECK_WITHIN(std::abs(pressure - law.slope(depth)), 1e-5 * (1.0 + law.slope(depth)));
  }
  CHECK(law.energy(-1.0) == 0.0);
  CHECK(law.slope(-1.0) == 0.0);
  CHECK_WITHIN(std::abs(law.slope(1e-12) / 4e8 - 1.0), 1e-6);
}

TEST_CASE("contact law: depth undoes pressure") {
  CHECK(law.depth(-1.0) == 0.0);
  CHECK(law.depth(0.0) == 0.0);
  for (const double depth : {1e-9, 1e-6, 1e-5, 2.5e-5, 3.9e-5, 4.1e-5, 2e-4})
    CHECK_WITHIN(std::abs(law.depth(law.pressure(depth)) / depth - 1.0), 1e-14);
}

TEST_CASE("contact law: energy, pressure and slope have no jump where the law goes on in a straight line") {
  const double limit = 0.8 * law.deepest;
  for (const double depth : {0.0, limit}) {
    const double before = depth - 1e-14, after = depth + 1e-14;
    CHECK_WITHIN(std::abs(law.energy(after) - law.energy(before)) / law.energy(limit), 1e-8);
    CHECK_WITHIN(std::abs(law.pressure(after) - law.pressure(before)) / law.pressure(limit), 1e-8);
  }
  CHECK_WITHIN(std::abs(law.slope(limit * (1 + 1e-12)) / law.slope(limit * (1 - 1e-12)) - 1.0), 1e-9);
}

TEST_CASE("contact law: traction grows with the slip up to its bound, then keeps its direction") {
  const Vector3 before(300.0, -100.0, 0.0), slip(2e-6, 5e-6, 0.0);
  const Vector3 trial = law.trial_traction(before, slip);
  CHECK_WITHIN((trial - Vector3(900.0, 1400.0, 0.0)).norm(), 1e-12);
  CHECK(ContactLaw::bounded(trial, trial.norm()) == trial);
  const Vector3 sliding = ContactLaw::bounded(trial, 600.0);
  CHECK_WITHIN(std::abs(sliding.norm() - 600.0), 1e-12);
  CHECK_WITHIN(sliding.cross(trial).norm() / (sliding.norm() * trial.norm()), 1e-15);
  CHECK(sliding.dot(trial) > 0.0);
  CHECK(ContactLaw::bounded(Vector3::Zero(), 0.0) == Vector3::Zero());
  CHECK(ContactLaw::bounded(trial, 0.0).norm() == 0.0);
}

TEST_CASE("contact law: traction is the slope of the friction energy, its slope that of the traction") {
  Random random(221);
  int sticking = 0, sliding = 0;
  for (int k = 0; k < 40; ++k) {
    // Slips in the plane across a unit normal.
    const Vector3 n = random.matrix(1.0).col(0).normalized();
    const Matrix3 tangential = Matrix3::Identity() - n * n.transpose();
    const Vector3 before = tangential * (1000.0 * random.matrix(1.0).col(0));
    const Vector3 slip = tangential * (1e-5 * random.matrix(1.0).col(0));
    const double bound = random(100.0, 4000.0);
    const Vector3 trial = law.trial_traction(before, slip), traction = ContactLaw::bounded(trial, bound);
    if (std::abs(trial.norm() - bound) < 10.0) continue;  // differences would cross the corner
    ++(trial.norm() < bound ? sticking : sliding);
    const Matrix3 found = law.friction_slope(trial, bound, tangential);
    for (int axis = 0; axis < 3; ++axis) {
      const auto moved = [&](double h) {
        return law.trial_traction(before, tangential * (slip + h * Vector3::Unit(axis)));
      };
      const double energy_slope = slope([&](double h) { return law.friction_energy(moved(h), bound); }, 1e-9);
      CHECK_WITHIN(std::abs(energy_slope - traction[axis]), 3e-7);  // of 1000; rounding eps E / h
      const Vector3 change = derivative([&](double h) { return ContactLaw::bounded(moved(h), bound); }, 1e-8);
      CHECK_WITHIN((change - found.col(axis)).norm() / law.tangential_stiffness, 1e-9);  // truncation near small slips
    }
    CHECK_WITHIN((found - found.transpose()).norm() / law.tangential_stiffness, 1e-15);
  }
  CHECK(sticking > 5);
  CHECK(sliding > 5);
}

TEST_CASE("contact law: the friction energy has no jump where points begin to slide") {
  const Vector3 trial(600.0, 0.0, 0.0);
  CHECK_WITHIN(std::abs(law.friction_energy(trial, 600.0) - law.friction_energy(trial, 600.0 * (1 - 1e-9))), 1e-15);
}

}  // namespace glossa::test
