#include "effect/block_matrix.hpp"

#include <algorithm>
#include <string>

#include "../fixture.hpp"
#include "random_tangents.hpp"

namespace glossa::test {
namespace {

std::vector<Index> scrambled_order(const std::vector<Index>& column_start, const std::vector<Index>& row) {
  std::vector<Index> order = natural_order(column_start, row);
  std::reverse(order.begin(), order.end());
  std::rotate(order.begin(), order.begin() + 3, order.end());
  std::swap(order[1], order[5]);
  return order;
}

/// Two groups of nodes coupled across elements; node 18 is an outside point.
Rows<Index> couplings() {
  Rows<Index> rows;
  for (const std::vector<Index>& group : {std::vector<Index>{0, 17, 5}, std::vector<Index>{18, 2, 15}}) {
    rows.values.insert(rows.values.end(), group.begin(), group.end());
    rows.push_row();
  }
  return rows;
}

/// Two by one by two elements with random contributions; node 4 held in y only, node 3 held, node 18 outside.
struct Assembly {
  HexMesh mesh = block(2, 1, 2, 0.0, 0.01, 1);
  FreeMask free = FreeMask(57, 1);
  std::vector<double> tangents, masses;
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(57, 57);

  explicit Assembly(double mass_scale) {
    free[3 * 4 + 1] = 0;
    for (const std::size_t held : {9, 10, 11}) free[held] = 0;
    Random random(71);
    random_tangents(mesh, random, tangents, masses, [&](Index a, Index b, const Matrix3& block, double mass) {
      put(a, b, block + mass_scale * mass * Matrix3::Identity());
    });
  }
  void put(Index a, Index b, const Matrix3& block) {
    expected.block<3, 3>(3 * a, 3 * b) += block;
    if (a != b) expected.block<3, 3>(3 * b, 3 * a) += block.transpose();
  }
  [[nodiscard]] BlockMatrix layout(NodeOrdering ordering) const {
    return {mesh.node_count(), free, mesh.hexahedra(), couplings(), ordering};
  }
  /// The expected matrix in the numbering of the unknowns.
  [[nodiscard]] Eigen::MatrixXd renumbered(const BlockMatrix& matrix) const {
    return expected(matrix.component_of_unknown(), matrix.component_of_unknown());
  }
};

}  // namespace

TEST_CASE("block matrix: gathered tangents, masses, couplings and shift equal a dense assembly") {
  for (const NodeOrdering ordering : {&natural_order, &scrambled_order}) {
    Assembly assembly(2.5);
    BlockMatrix matrix = assembly.layout(ordering);
    matrix.set_mass(assembly.masses);
    matrix.gather(assembly.tangents, 2.5, 1);
    CHECK_WITHIN(worst_entry(dense(matrix.columns(1)), assembly.renumbered(matrix)), 1e-15);

    Random random(72);
    const Matrix3 off = random.matrix(1.0), more = random.matrix(1.0);
    Matrix3 diagonal = random.matrix(1.0);
    diagonal = (diagonal + diagonal.transpose()).eval();
    for (const auto& [a, b, block] :
         {std::tuple{0, 17, off}, {17, 5, more}, {4, 3, off}, {4, 1, more}, {2, 2, diagonal}, {18, 2, off}}) {
      matrix.add(a, b, block);
      assembly.put(a, b, block);
    }
    matrix.shift_diagonal(0.7);
    assembly.expected.diagonal().array() += 0.7;
    CHECK_WITHIN(worst_entry(dense(matrix.columns(1)), assembly.renumbered(matrix)), 1e-15);
    matrix.gather(assembly.tangents, 2.5, 1);
    CHECK(worst_entry(dense(matrix.columns(1)), assembly.renumbered(matrix)) > 1e-2);  // gathering starts anew
  }
}

TEST_CASE("block matrix: unknowns are the free components of nodes in elements, columns lower and sorted") {
  const Assembly assembly(0.0);
  BlockMatrix matrix = assembly.layout(&scrambled_order);
  CHECK(matrix.unknown_count() == 3 * 18 - 4);
  std::vector<Index> components = matrix.component_of_unknown();
  std::sort(components.begin(), components.end());
  std::vector<Index> expected;
  for (Index c = 0; c < 54; ++c)
    if (assembly.free[static_cast<std::size_t>(c)]) expected.push_back(c);
  CHECK(components == expected);
  const LowerColumns& columns = matrix.columns(1);
  for (Index j = 0; j < matrix.unknown_count(); ++j) {
    const auto begin = columns.row.begin() + columns.column_start[static_cast<std::size_t>(j)];
    const auto end = columns.row.begin() + columns.column_start[static_cast<std::size_t>(j) + 1];
    CHECK(*begin == j);
    CHECK(std::adjacent_find(begin, end, std::greater_equal<>{}) == end);
  }
}

TEST_CASE("block matrix: an extra coupling costs its own blocks only") {
  const Assembly assembly(0.0);
  const BlockMatrix with = assembly.layout(&natural_order);
  const BlockMatrix without(assembly.mesh.node_count(), assembly.free, assembly.mesh.hexahedra(), {}, &natural_order);
  CHECK(with.block_count() == without.block_count() + 4);  // 0-5, 0-17, 5-17 and 2-15
}

TEST_CASE("block matrix: refusals") {
  const Assembly assembly(0.0);
  const BlockMatrix matrix = assembly.layout(&natural_order);
  CHECK_THROWS_WITH_AS((void)matrix.slot(0, 14), "tangent: nodes 0 and 14 are not coupled in the layout", InputError);
  CHECK(matrix.slot(3, 14).block == -1);
  CHECK(matrix.slot(18, 0).block == -1);
  CHECK_THROWS_WITH_AS(BlockMatrix(19, FreeMask(57, 0), assembly.mesh.hexahedra(), {}, &natural_order),
                       "constraints: every node is held, nothing is left to solve for", InputError);
}

}  // namespace glossa::test
