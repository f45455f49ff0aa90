// Nodes tied to a bone in the block matrix: P' K P, P being dx / d unknowns, assembled densely.
#include <algorithm>

#include "../fixture.hpp"
#include "effect/block_matrix.hpp"
#include "random_tangents.hpp"

namespace glossa::test {
namespace {

constexpr Index centre = 19, turn = 20, nodes = 22;

std::vector<Index> reversed_order(const std::vector<Index>& column_start, const std::vector<Index>& row) {
  std::vector<Index> order = natural_order(column_start, row);
  std::reverse(order.begin(), order.end());
  std::swap(order[2], order[6]);
  return order;
}

/// Two by one by two elements and four outside nodes: 18 is tied like 5, 8, 9 and 14, 19 and 20 are the pose, 21 is an
/// anchor. Node 3 is held, node 4 in y.
struct Assembly {
  HexMesh mesh = block(2, 1, 2, 0.0, 0.01, 4);
  Ties ties{{5, 8, 9, 14, 18}, centre, turn};
  FreeMask free = FreeMask(3 * nodes, 1);
  std::vector<Matrix3> turn_gradients;
  std::vector<double> tangents, masses;
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(3 * nodes, 3 * nodes);

  explicit Assembly(const std::vector<std::size_t>& held_of_pose) {
    for (const std::size_t c : {9, 10, 11, 13, 63, 64, 65}) free[c] = 0;
    for (const Index n : ties.nodes) std::fill_n(free.begin() + 3 * n, 3, std::uint8_t{0});
    for (const std::size_t c : held_of_pose) free[57 + c] = 0;
    Random random(231);
    for (std::size_t k = 0; k < ties.nodes.size(); ++k) turn_gradients.push_back(random.matrix(1.0));
    random_tangents(mesh, random, tangents, masses, [&](Index a, Index b, const Matrix3& block, double mass) {
      put(a, b, block + 2.5 * mass * Matrix3::Identity());
    });
  }
  void put(Index a, Index b, const Matrix3& block) {
    K.block<3, 3>(3 * a, 3 * b) += block;
    if (a != b) K.block<3, 3>(3 * b, 3 * a) += block.transpose();
  }
  /// Groups across elements: tied with free, tied with tied, all on the bone, an outside point of the bone with the
  /// anchor.
  [[nodiscard]] static Rows<Index> couplings() {
    Rows<Index> rows;
    for (const std::vector<Index>& group : {std::vector<Index>{0, 14, 17}, std::vector<Index>{5, 18},
                                            std::vector<Index>{18, 2, 8}, std::vector<Index>{18, 21}}) {
      rows.values.insert(rows.values.end(), group.begin(), group.end());
      rows.push_row();
    }
    return rows;
  }
  [[nodiscard]] BlockMatrix layout(NodeOrdering ordering) const {
    BlockMatrix matrix(mesh.node_count(), free, mesh.hexahedra(), couplings(), ordering, &ties);
    matrix.set_mass(masses);
    return matrix;
  }
  /// P' K P in the numbering of the unknowns.
  [[nodiscard]] Eigen::MatrixXd expected(const BlockMatrix& matrix) const {
    Eigen::MatrixXd P = Eigen::MatrixXd::Identity(3 * nodes, 3 * nodes);
    for (std::size_t k = 0; k < ties.nodes.size(); ++k) {
      const Index n = ties.nodes[k];
      P.block<3, 3>(3 * n, 3 * n).setZero();
      P.block<3, 3>(3 * n, 3 * centre).setIdentity();
      P.block<3, 3>(3 * n, 3 * turn) = turn_gradients[k];
    }
    const Eigen::MatrixXd reduced = P.transpose() * K * P;
    return reduced(matrix.component_of_unknown(), matrix.component_of_unknown());
  }
  /// Adds blocks of every kind to both matrices.
  void add_effects(BlockMatrix& matrix) {
    Random random(232);
    Matrix3 diagonal = random.matrix(1.0);
    diagonal = (diagonal + diagonal.transpose()).eval();
    for (const auto& [a, b] : {std::pair{14, 0},
                               {0, 17},
                               {17, 14},
                               {18, 5},
                               {5, 18},
                               {2, 18},
                               {8, 2},
                               {8, 18},
                               {18, 21},
                               {9, 3},
                               {10, 9},
                               {14, 17}}) {
      const Matrix3 block = random.matrix(1.0);
      matrix.add(a, b, block);
      put(a, b, block);
    }
    for (const Index n : {18, 14, 1}) {
      matrix.add(n, n, diagonal);
      put(n, n, diagonal);
    }
  }
};

/// Held components of the pose: none, as in a mirrored half, rotation only, translation only.
const std::vector<std::vector<std::size_t>> poses{{}, {1, 3, 5}, {0, 1, 2}, {3, 4, 5}, {0, 1, 2, 3, 5}};

}  // namespace

TEST_CASE("block matrix: eliminating tied nodes gives P' K P, whatever of the pose is free and in which order") {
  for (const auto& held : poses)
    for (const NodeOrdering ordering : {&natural_order, &reversed_order}) {
      Assembly assembly(held);
      BlockMatrix matrix = assembly.layout(ordering);
      CHECK(matrix.unknown_count() == 3 * 18 - 4 * 3 - 4 + 6 - static_cast<Index>(held.size()));
      for (int round = 0; round < 2; ++round) {  // gathering starts anew
        matrix.gather(assembly.tangents, 2.5, 1 + round);
        matrix.eliminate(assembly.turn_gradients);
        CHECK_WITHIN(worst_entry(dense(matrix.columns(1)), assembly.expected(matrix)), 1e-15);
      }
      matrix.gather(assembly.tangents, 2.5, 1);
      assembly.add_effects(matrix);
      matrix.eliminate(assembly.turn_gradients);
      const Matrix3 curvature = Vector3(1.0, -2.0, 3.0).asDiagonal();
      matrix.add(turn, turn, curvature);
      matrix.shift_diagonal(0.7);
      Eigen::MatrixXd expected = assembly.expected(matrix);
      expected.diagonal().array() += 0.7;
      for (Eigen::Index k = 0; k < expected.rows(); ++k) {
        const Index component = matrix.component_of_unknown()[static_cast<std::size_t>(k)];
        if (component >= 3 * turn) expected(k, k) += curvature.diagonal()(component - 3 * turn);
      }
      CHECK_WITHIN(worst_entry(dense(matrix.columns(1)), expected), 1e-15);
    }
}

TEST_CASE("block matrix: the order of the nodes changes the numbering only, tied nodes have no unknowns") {
  Assembly assembly({1, 3, 5});
  const auto full = [&](NodeOrdering ordering) {
    BlockMatrix matrix = assembly.layout(ordering);
    for (const Index c : matrix.component_of_unknown()) {
      CHECK(assembly.free[static_cast<std::size_t>(c)] == 1);
      CHECK_FALSE(std::binary_search(assembly.ties.nodes.begin(), assembly.ties.nodes.end(), c / 3));
    }
    matrix.gather(assembly.tangents, 2.5, 1);
    matrix.eliminate(assembly.turn_gradients);
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(3 * nodes, 3 * nodes);
    result(matrix.component_of_unknown(), matrix.component_of_unknown()) = dense(matrix.columns(1));
    return result;
  };
  CHECK_WITHIN(worst_entry(full(&natural_order), full(&reversed_order)), 1e-15);
}

TEST_CASE("block matrix: the lower columns of a matrix with ties are sorted and start with the diagonal") {
  Assembly assembly({1, 3, 5});
  BlockMatrix matrix = assembly.layout(&reversed_order);
  const LowerColumns& columns = matrix.columns(1);
  REQUIRE(columns.column_start.size() == static_cast<std::size_t>(matrix.unknown_count()) + 1);
  for (Index j = 0; j < matrix.unknown_count(); ++j) {
    const auto begin = columns.row.begin() + columns.column_start[static_cast<std::size_t>(j)];
    const auto end = columns.row.begin() + columns.column_start[static_cast<std::size_t>(j) + 1];
    CHECK(*begin == j);
    CHECK(std::adjacent_find(begin, end, std::greater_equal<>{}) == end);
    CHECK(*(end - 1) < matrix.unknown_count());
  }
}

TEST_CASE("block matrix: point masses at tied, free and held nodes") {
  Assembly assembly({});
  BlockMatrix matrix = assembly.layout(&reversed_order);
  for (const auto& [node, mass] : {std::pair{18, 3.0}, {5, 0.25}, {5, 0.5}, {7, 2.0}, {3, 100.0}, {21, 100.0}}) {
    matrix.add_mass(node, mass);
    assembly.put(node, node, 2.5 * mass * Matrix3::Identity());
  }
  matrix.gather(assembly.tangents, 2.5, 1);
  matrix.eliminate(assembly.turn_gradients);
  CHECK_WITHIN(worst_entry(dense(matrix.columns(1)), assembly.expected(matrix)), 1e-15);
}

TEST_CASE("block matrix: a bone alone has the unknowns of its pose") {
  Assembly assembly({});
  for (Index n = 0; n < 18; ++n) std::fill_n(assembly.free.begin() + 3 * n, 3, std::uint8_t{0});
  BlockMatrix matrix = assembly.layout(&natural_order);
  CHECK(matrix.unknown_count() == 6);
  matrix.gather(assembly.tangents, 2.5, 1);
  assembly.add_effects(matrix);
  matrix.eliminate(assembly.turn_gradients);
  CHECK_WITHIN(worst_entry(dense(matrix.columns(1)), assembly.expected(matrix)), 1e-15);
}

}  // namespace glossa::test
