#include "mesh/hex_element.hpp"

#include "../fixture.hpp"

namespace glossa::test {

TEST_CASE("hexahedron: shape functions are 1 at their own corner, 0 at the others, and add up to 1") {
  for (std::size_t a = 0; a < hex::corners; ++a)
    for (std::size_t b = 0; b < hex::corners; ++b) CHECK(hex::shape(hex::corner[b])[a] == (a == b ? 1.0 : 0.0));
  const hex::CornerValues n = hex::shape({0.3, -0.7, 0.2});
  double total = 0.0;
  for (const double value : n) total += value;
  CHECK_WITHIN(std::abs(total - 1.0), 1e-15);
}

TEST_CASE("hexahedron: gradients of the shape functions against differences") {
  const std::array<double, 3> xi{0.3, -0.7, 0.2};
  const hex::CornerGradients gradient = hex::shape_gradient(xi);
  hex::CornerGradients reference;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t a = 0; a < hex::corners; ++a)
      reference(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(a)) = slope(
          [&](double h) {
            auto moved = xi;
            moved[i] += h;
            return hex::shape(moved)[a];
          },
          0.1);
  CHECK_WITHIN(worst_entry(gradient, reference), 2e-14);  // linear in each coordinate: rounding only
}

TEST_CASE("hexahedron: corners of every face run anticlockwise seen from outside") {
  for (const auto& face : hex::faces) {
    std::array<Vector3, 4> x;
    for (std::size_t k = 0; k < 4; ++k)
      x[k] = Eigen::Map<const Vector3>(hex::corner[static_cast<std::size_t>(face[k])].data());
    const Vector3 normal = (x[1] - x[0]).cross(x[2] - x[1]);
    const Vector3 centre = (x[0] + x[1] + x[2] + x[3]) / 4.0;
    CHECK(normal.dot(centre) == doctest::Approx(4.0));
  }
}

TEST_CASE("hexahedron: the Gauss rule integrates cubics exactly") {
  double even = 0.0, odd = 0.0;
  for (std::size_t q = 0; q < hex::points; ++q) {
    const auto xi = hex::gauss_point(q);
    even += xi[0] * xi[0] * xi[1] * xi[1];
    odd += xi[0] * xi[0] * xi[0] + xi[1] * xi[2] * xi[2];
  }
  CHECK_WITHIN(std::abs(even - 8.0 / 9.0), 1e-15);
  CHECK_WITHIN(std::abs(odd), 1e-15);
}

}  // namespace glossa::test
