#include "muscle/stiffening.hpp"

#include "fibres.hpp"

namespace glossa::test {

TEST_CASE("stiffening: eq. 1 adds p1 A over the fibres of each element, up to saturation") {
  const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  const Macrofibres fibres = three_fibres(mesh);
  const ForceLaw law;
  const double top = law.saturation_activation();
  std::vector<double> factors(8, 99.0);
  const auto of = [&](const std::vector<double>& activation) {
    stiffening_factors(fibres, activation, law, factors);
    return factors;
  };
  CHECK(of({0.0, -0.01, 0.0}) == std::vector<double>(8, 1.0));
  const auto both = of({0.010, 0.005, 0.010});
  CHECK_WITHIN(std::abs(both[0] - 1.8), 1e-15);
  CHECK_WITHIN(std::abs(both[3] - 1.9), 1e-15);
  CHECK_WITHIN(std::abs(both[7] - 1.5), 1e-15);
  CHECK(both[1] == 1.0);
  CHECK_WITHIN(std::abs(of({0.050, 0.0, 0.0})[0] - (1.0 + 80.0 * top)), 1e-15);
  CHECK(of({0.050, 0.0, 0.0}) == of({top, 0.0, 0.0}));
}

}  // namespace glossa::test
