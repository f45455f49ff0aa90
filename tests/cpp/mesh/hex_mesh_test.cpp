#include "mesh/hex_mesh.hpp"

#include <limits>

#include "../fixture.hpp"

namespace glossa::test {
namespace {

/// A unit cube of 1 cm after `change` was applied to its nodes and its corners.
template <class Change>
HexMesh changed(Change&& change) {
  const HexMesh cube = block(1, 1, 1);
  NodeField nodes = cube.nodes();
  std::vector<Hexahedron> hexahedra = cube.hexahedra();
  change(nodes, hexahedra);
  return {nodes, hexahedra};
}

}  // namespace

TEST_CASE("hex mesh: volumes, counts and outside nodes") {
  const HexMesh mesh = block(3, 2, 1, 0.15, 0.01, 2);
  CHECK(mesh.node_count() == 24 + 2);
  CHECK(mesh.element_count() == 6);
  CHECK_FALSE(mesh.outside(23));
  CHECK(mesh.outside(24));
  CHECK(mesh.outside(25));
  double volume = 0.0;
  const HexMesh regular = block(3, 2, 1);
  for (Index e = 0; e < 6; ++e) volume += regular.volume(e);
  CHECK_WITHIN(std::abs(volume / 6e-6 - 1.0), 1e-14);
}

TEST_CASE("hex mesh: extent is the longest edge of the box around the hexahedra, outside nodes left out") {
  CHECK(block(3, 2, 1, 0.0, 0.01, 4).extent() == doctest::Approx(0.03).epsilon(1e-15));
  CHECK(block(1, 2, 4).extent() == doctest::Approx(0.04).epsilon(1e-15));
}

TEST_CASE("hex mesh: volume of a sheared and stretched cube is the determinant of the map") {
  Random random(3);
  const Matrix3 F = Matrix3::Identity() + random.matrix(0.4);
  const HexMesh mesh(mapped(block(1, 1, 1).nodes(), F), block(1, 1, 1).hexahedra());
  CHECK_WITHIN(std::abs(mesh.volume(0) / (1e-6 * F.determinant()) - 1.0), 1e-14);
}

TEST_CASE("hex mesh: refusals name what and where") {
  using Nodes = NodeField;
  using Hexahedra = std::vector<Hexahedron>;
  CHECK_THROWS_WITH_AS(changed([](Nodes&, Hexahedra& h) { h.clear(); }), "mesh: at least one hexahedron is needed",
                       InputError);
  CHECK_THROWS_WITH_AS(changed([](Nodes& x, Hexahedra&) { x[3 * 5 + 1] = std::numeric_limits<double>::quiet_NaN(); }),
                       "node 5: its coordinates must be finite", InputError);
  CHECK_THROWS_WITH_AS(changed([](Nodes& x, Hexahedra&) { x[3 * 2] = std::numeric_limits<double>::infinity(); }),
                       "node 2: its coordinates must be finite", InputError);
  CHECK_THROWS_WITH_AS(changed([](Nodes&, Hexahedra& h) { h[0][3] = 8; }), "hexahedron 0: node index 8 is outside 0..7",
                       InputError);
  CHECK_THROWS_WITH_AS(changed([](Nodes&, Hexahedra& h) { h[0][3] = -1; }),
                       "hexahedron 0: node index -1 is outside 0..7", InputError);
  CHECK_THROWS_WITH_AS(changed([](Nodes&, Hexahedra& h) { h[0][3] = h[0][6]; }),
                       "hexahedron 0: node 7 appears more than once; collapsed hexahedra are not supported",
                       InputError);
}

TEST_CASE("hex mesh: inverted and degenerate hexahedra are refused") {
  const auto message = [](auto&& change) -> std::string {
    try {
      changed(change);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  using Nodes = NodeField;
  using Hexahedra = std::vector<Hexahedron>;
  // Upside down; flat; one corner pushed through the opposite face, so that only corners see it.
  const std::string upside_down =
      message([](Nodes&, Hexahedra& h) { std::swap_ranges(h[0].begin(), h[0].begin() + 4, h[0].begin() + 4); });
  CHECK(upside_down.find("hexahedron 0: inverted or degenerate, its smallest Jacobian is -1.25e-07 m3") == 0);
  CHECK(upside_down.find("VTK order") != std::string::npos);
  CHECK(message([](Nodes& x, Hexahedra&) {
          for (std::size_t n = 4; n < 8; ++n) x[3 * n + 2] = 0.0;
        }).find("smallest Jacobian is 0 m3") != std::string::npos);
  CHECK(message([](Nodes& x, Hexahedra&) { x[3 * 7 + 2] = -1e-4; }).find("inverted or degenerate") !=
        std::string::npos);
  CHECK(message([](Nodes& x, Hexahedra&) { x[3 * 7 + 2] = 9e-3; }) == "accepted");
}

}  // namespace glossa::test
