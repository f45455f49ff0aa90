// A hexahedron written the straightforward way: B matrices, point law at every Gauss point, no batches.
#pragma once

#include "../fixture.hpp"
#include "effect/elasticity_kernel.hpp"

namespace glossa::test {

using Force24 = Eigen::Matrix<double, 24, 1>;
using Matrix24 = Eigen::Matrix<double, 24, 24>;

struct ElementState {
  double stiffening = 1.0;  ///< scale of the isochoric part
  double volumetric = 1.0;  ///< scale of the volumetric part
  double pressure = 0.0;    ///< of the geometric stiffness (mean dilatation), Pa
};

struct ElementResult {
  Force24 force = Force24::Zero();
  Matrix24 tangent = Matrix24::Zero();
  Force24 volume_gradient = Force24::Zero();
  double dilatation = 0.0, isochoric_energy = 0.0, volumetric_energy = 0.0, least_jacobian = 1e300;
};

/// Rest and current corner positions of element e of `mesh`.
[[nodiscard]] ElementResult reference_element(const HexMesh& mesh, Index element, const NodeField& positions,
                                              const Yeoh& law, const ElementState& state, bool mean_dilatation);

/// The full matrix of 36 packed corner pairs.
[[nodiscard]] Matrix24 unpacked(const double* blocks);

}  // namespace glossa::test
