#include "effect/quadratic_rest.hpp"

#include <algorithm>

#include <Eigen/LU>

#include "mesh/quadratic_hex.hpp"

namespace glossa {
namespace {

Matrix3 rest_jacobian(const HexMesh& mesh, const Index* nodes, const hex27::NodeGradients& gradient) {
  Matrix3 jacobian = Matrix3::Zero();
  for (std::size_t a = 0; a < hex27::nodes; ++a)
    jacobian += at(mesh.nodes(), nodes[a]) * gradient.col(static_cast<Eigen::Index>(a)).transpose();
  return jacobian;
}

void fill_lane(const HexMesh& mesh, const QuadraticCells& cells, std::size_t cell, QuadraticBatch& batch,
               std::size_t lane) {
  const Index* nodes = cells.cells.begin(cell);
  Eigen::Matrix4d moment = Eigen::Matrix4d::Zero();
  for (std::size_t q = 0; q < hex27::points; ++q) {
    const auto [xi, gauss_weight] = hex27::gauss_point(q);
    const hex27::NodeGradients natural = hex27::shape_gradient(xi);
    const Matrix3 jacobian = rest_jacobian(mesh, nodes, natural);
    const hex27::NodeGradients gradient = jacobian.inverse().transpose() * natural;
    for (std::size_t a = 0; a < hex27::nodes; ++a)
      for (std::size_t i = 0; i < 3; ++i)
        batch.gradient[q][a][i][lane] = gradient(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(a));
    batch.weight[q][lane] = gauss_weight * jacobian.determinant();
    const Eigen::Vector4d phi(1.0, xi[0], xi[1], xi[2]);
    moment += batch.weight[q][lane] * phi * phi.transpose();
  }
  const Eigen::Matrix4d inverse = moment.inverse();
  for (std::size_t m = 0; m < 4; ++m)
    for (std::size_t n = 0; n < 4; ++n)
      batch.inverse_moment[m][n][lane] = inverse(static_cast<Eigen::Index>(m), static_cast<Eigen::Index>(n));
  for (std::size_t a = 0; a < hex27::nodes; ++a) batch.corner[a][lane] = nodes[a];
  for (std::size_t o = 0; o < hex27::octants; ++o) batch.octant[o][lane] = cells.octants[cell][o];
}

}  // namespace

std::vector<QuadraticBatch> quadratic_batches(const HexMesh& mesh, const QuadraticCells& cells) {
  const std::size_t count = cells.cells.count();
  std::vector<QuadraticBatch> batches((count + lanes - 1) / lanes);
  for (std::size_t c = 0; c < batches.size() * lanes; ++c)
    // Lanes beyond the last cell repeat it: they write what it writes.
    fill_lane(mesh, cells, std::min(c, count - 1), batches[c / lanes], c % lanes);
  return batches;
}

std::vector<double> quadratic_masses(const HexMesh& mesh, const Cells& cells, double density) {
  std::vector<double> masses;
  masses.reserve(cells.pairs() * cells.count());
  for (std::size_t c = 0; c < cells.count(); ++c) {
    std::vector<double> pair_mass(cells.pairs(), 0.0);
    for (std::size_t q = 0; q < hex27::points; ++q) {
      const auto [xi, weight] = hex27::gauss_point(q);
      const double w = density * weight * rest_jacobian(mesh, cells.begin(c), hex27::shape_gradient(xi)).determinant();
      const hex27::NodeValues n = hex27::shape(xi);
      std::size_t pair = 0;
      for (std::size_t b = 0; b < hex27::nodes; ++b)
        for (std::size_t a = 0; a <= b; ++a, ++pair) pair_mass[pair] += w * n[a] * n[b];
    }
    masses.insert(masses.end(), pair_mass.begin(), pair_mass.end());
  }
  return masses;
}

}  // namespace glossa
