#include "reference_element.hpp"

#include "material/yeoh_point.hpp"
#include "mesh/hex_element.hpp"

namespace glossa::test {
namespace {

using Strain = Eigen::Matrix<double, 9, 24>;
using Tangent9 = Eigen::Matrix<double, 9, 9>;

Matrix3 cofactor(const Matrix3& F) {
  Matrix3 result;
  for (Eigen::Index j = 0; j < 3; ++j) result.col(j) = F.col((j + 1) % 3).cross(F.col((j + 2) % 3));
  return result;
}

/// d cof F / dF: the cofactor is quadratic, so that a difference of any size is exact.
Tangent9 cofactor_derivative(const Matrix3& F) {
  Tangent9 result;
  for (Eigen::Index k = 0; k < 9; ++k) {
    Matrix3 direction = Matrix3::Zero();
    direction.reshaped()(k) = 1.0;
    result.col(k) = (0.5 * (cofactor(F + direction) - cofactor(F - direction))).reshaped();
  }
  return result;
}

Eigen::Matrix<double, 3, 8> corners(const HexMesh& mesh, Index element, const NodeField& positions) {
  Eigen::Matrix<double, 3, 8> result;
  for (std::size_t a = 0; a < 8; ++a)
    result.col(static_cast<Eigen::Index>(a)) = at(positions, mesh.hexahedra()[static_cast<std::size_t>(element)][a]);
  return result;
}

/// vec(dF) = B dx for the reference gradients G of the corners.
Strain strain_matrix(const hex::CornerGradients& G) {
  Strain B = Strain::Zero();
  for (Eigen::Index a = 0; a < 8; ++a)
    for (Eigen::Index i = 0; i < 3; ++i)
      for (Eigen::Index j = 0; j < 3; ++j) B(i + 3 * j, 3 * a + i) = G(j, a);
  return B;
}

}  // namespace

ElementResult reference_element(const HexMesh& mesh, Index element, const NodeField& positions, const Yeoh& law,
                                const ElementState& state, bool mean_dilatation) {
  const auto rest = corners(mesh, element, mesh.nodes()), current = corners(mesh, element, positions);
  const Yeoh isochoric{law.c10, law.c20, 0.0}, volumetric{0.0, 0.0, law.kappa};
  ElementResult r;
  double rest_volume = 0.0, volume = 0.0;
  Matrix24 geometric = Matrix24::Zero();
  for (std::size_t q = 0; q < hex::points; ++q) {
    const hex::CornerGradients natural = hex::shape_gradient(hex::gauss_point(q));
    const Matrix3 jacobian = rest * natural.transpose();
    const Strain B = strain_matrix(jacobian.inverse().transpose() * natural);
    const double w = jacobian.determinant();
    const Matrix3 F = (B * current.reshaped()).reshaped(3, 3);
    const YeohPoint iso = evaluate(isochoric, F), vol = evaluate(volumetric, F);
    r.isochoric_energy += w * iso.energy;
    r.force += state.stiffening * w * B.transpose() * iso.stress.reshaped();
    r.tangent += state.stiffening * w * B.transpose() * iso.tangent * B;
    rest_volume += w;
    volume += w * F.determinant();
    r.least_jacobian = std::min(r.least_jacobian, F.determinant());
    r.volume_gradient += w * B.transpose() * cofactor(F).reshaped();
    geometric += w * B.transpose() * cofactor_derivative(F) * B;
    if (mean_dilatation) continue;
    r.volumetric_energy += w * vol.energy;
    r.force += state.volumetric * w * B.transpose() * vol.stress.reshaped();
    r.tangent += state.volumetric * w * B.transpose() * vol.tangent * B;
  }
  r.dilatation = volume / rest_volume;
  if (!mean_dilatation) return r;
  r.volumetric_energy = rest_volume * law.volumetric(r.dilatation);
  r.force += state.volumetric * law.pressure(r.dilatation) * r.volume_gradient;
  r.tangent += state.volumetric * (state.pressure * geometric +
                                   law.kappa / rest_volume * r.volume_gradient * r.volume_gradient.transpose());
  return r;
}

Matrix24 unpacked(const double* blocks) {
  Matrix24 result;
  for (Eigen::Index b = 0; b < 8; ++b)
    for (Eigen::Index a = 0; a <= b; ++a, blocks += 9) {
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(blocks);
      result.block<3, 3>(3 * a, 3 * b) = block;
      result.block<3, 3>(3 * b, 3 * a) = block.transpose();
    }
  return result;
}

}  // namespace glossa::test
