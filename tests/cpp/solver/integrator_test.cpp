#include "solver/integrator.hpp"

#include "../fixture.hpp"

namespace glossa::test {

TEST_CASE("integrator: gamma of SDIRK2 is 1 - 1 / sqrt 2, the root of second order") {
  CHECK(sdirk2_gamma == doctest::Approx(1.0 - std::sqrt(0.5)).epsilon(1e-16));
  CHECK_WITHIN(std::abs(sdirk2_gamma * sdirk2_gamma - 2.0 * sdirk2_gamma + 0.5), 1e-16);
}

TEST_CASE("integrator: weights of BDF2 are exact for quadratics at any ratio of steps") {
  for (const double omega : {0.3, 1.0, 1.9}) {
    const Bdf2 w(omega);
    const double h = omega, last = 1.0;  // present time 0
    const auto u = [](double t) { return 2.0 + 3.0 * t - 5.0 * t * t; };
    const double rate = 3.0 - 10.0 * h;
    CHECK_WITHIN(std::abs(w.a * u(0.0) - w.b * u(-last) + w.c * h * rate - u(h)), 3e-14);
  }
  CHECK(Bdf2(1.0).a == doctest::Approx(4.0 / 3.0));
  CHECK(Bdf2(1.0).b == doctest::Approx(1.0 / 3.0));
  CHECK(Bdf2(1.0).c == doctest::Approx(2.0 / 3.0));
}

}  // namespace glossa::test
