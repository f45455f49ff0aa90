#include "mesh/quadratic_cells.hpp"

#include <algorithm>
#include <numeric>

#include "../fixture.hpp"
#include "mesh/quadratic_hex.hpp"

namespace glossa::test {
namespace {

/// The same body: hexahedra in another order, each turned about an axis of its own.
HexMesh shuffled(const HexMesh& mesh, std::uint64_t seed) {
  constexpr std::array<std::array<std::size_t, 8>, 3> quarter_turns{
      {{1, 2, 3, 0, 5, 6, 7, 4}, {4, 5, 1, 0, 7, 6, 2, 3}, {3, 2, 6, 7, 0, 1, 5, 4}}};
  std::vector<Hexahedron> hexahedra = mesh.hexahedra();
  Random random(seed);
  for (std::size_t e = hexahedra.size(); e > 1; --e)
    std::swap(hexahedra[e - 1], hexahedra[static_cast<std::size_t>(random(0.0, static_cast<double>(e)))]);
  for (Hexahedron& hexahedron : hexahedra)
    for (int turn = 0; turn < 6; ++turn) {
      const auto& order = quarter_turns[static_cast<std::size_t>(random(0.0, 3.0))];
      const Hexahedron before = hexahedron;
      for (std::size_t a = 0; a < 8; ++a) hexahedron[a] = before[order[a]];
    }
  return {mesh.nodes(), std::move(hexahedra)};
}

/// Checks that cells are cubes of 2 x 2 x 2 hexahedra with their first nodes at even places of the block's lattice.
void check_cells(const HexMesh& mesh, const QuadraticCells& found, double cell) {
  std::vector<int> used(mesh.hexahedra().size(), 0);
  for (std::size_t c = 0; c < found.octants.size(); ++c) {
    const Index* nodes = found.cells.begin(c);
    for (std::size_t o = 0; o < 8; ++o) {
      const auto e = static_cast<std::size_t>(found.octants[c][o]);
      ++used[e];
      // The octant's corners are nodes of the cell, its centre lies where the octant's number says.
      Vector3 centre = Vector3::Zero();
      for (const Index node : mesh.hexahedra()[e]) {
        CHECK(std::find(nodes, nodes + 27, node) != nodes + 27);
        centre += at(mesh.nodes(), node) / 8.0;
      }
      std::array<double, 3> xi{};
      for (std::size_t d = 0; d < 3; ++d) xi[d] = (o >> d & 1U) != 0 ? 0.5 : -0.5;
      const hex27::NodeValues shape = hex27::shape(xi);
      for (std::size_t a = 0; a < 27; ++a) centre -= shape[a] * at(mesh.nodes(), nodes[a]);
      CHECK_WITHIN(centre.norm() / cell, 1e-14);
    }
    const Vector3 middle = at(mesh.nodes(), nodes[13]) / (2.0 * cell);
    for (Eigen::Index i = 0; i < 3; ++i) CHECK_WITHIN(std::abs(middle(i) - std::floor(middle(i)) - 0.5), 1e-14);
  }
  for (const int times : used) CHECK(times == 1);
}

}  // namespace

TEST_CASE("quadratic cells: found in any order and orientation of the hexahedra") {
  const HexMesh mesh = block(6, 2, 4);
  check_cells(mesh, quadratic_cells(mesh), 0.01);
  for (const std::uint64_t seed : {61U, 62U, 63U}) {
    const HexMesh other = shuffled(mesh, seed);
    const QuadraticCells found = quadratic_cells(other);
    REQUIRE(found.octants.size() == 6);
    check_cells(other, found, 0.01);
  }
}

TEST_CASE("quadratic cells: bodies that do not hang together are grouped one by one, each from its own start") {
  const HexMesh mesh = block(6, 2, 2);
  std::vector<Hexahedron> hexahedra;
  for (std::size_t e = 0; e < mesh.hexahedra().size(); ++e)
    if (e % 6 < 2 || e % 6 > 3) hexahedra.push_back(mesh.hexahedra()[e]);  // the middle cell is left out
  const HexMesh two(mesh.nodes(), hexahedra);
  const QuadraticCells found = quadratic_cells(two);
  REQUIRE(found.octants.size() == 2);
  check_cells(two, found, 0.01);
}

TEST_CASE("quadratic cells: an odd division is refused, naming a hexahedron and the cure") {
  for (const HexMesh& mesh : {block(3, 2, 2), block(4, 2, 1), block(4, 4, 5)})
    CHECK_THROWS_WITH_AS(
        quadratic_cells(mesh),
        "element Q2P1: hexahedron 0 belongs to no group of 2 x 2 x 2 hexahedra that fill its part of the body; divide "
        "the mesh by two: Speaker.refined(), or an even resolution of the reference speaker",
        InputError);
}

}  // namespace glossa::test
