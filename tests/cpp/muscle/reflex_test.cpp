#include "muscle/reflex.hpp"

#include "../fixture.hpp"

namespace glossa::test {

TEST_CASE("reflex: eq. 2") {
  const Reflex reflex;
  CHECK(reflex.delay == 0.017);
  CHECK_WITHIN(std::abs(reflex.activation(0.050, 0.045, 0.2) - 0.007), 1e-17);  // 5 mm + 0.01 s x 0.2 m/s
  CHECK_WITHIN(std::abs(reflex.activation(0.050, 0.045, -0.2) - 0.003), 1e-17);
  CHECK(reflex.activation(0.040, 0.045, 0.2) == 0.0);
  CHECK_WITHIN(std::abs(Reflex{0.0, 0.0}.activation(0.050, 0.045, 9.0) - 0.005), 1e-17);
}

}  // namespace glossa::test
