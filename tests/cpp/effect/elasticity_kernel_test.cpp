#include "effect/elasticity_kernel.hpp"

#include "core/instruction_set.hpp"
#include "effect/elasticity.hpp"
#include "reference_element.hpp"

namespace glossa::test {
namespace {

using Kernel = void (*)(const ElasticSweep&, int, int);

struct Kernels {
  Kernel forces = &sweep_forces, tangents = &sweep_tangents;
};

/// Everything that the sweeps write, for a deformed, distorted mesh of six elements: the last batch is half filled.
struct Sweep {
  HexMesh mesh = block(3, 2, 1, 0.2);
  std::shared_ptr<const RestBatches> batches = rest_batches(mesh);
  NodeField positions = sum(mapped(mesh.nodes(), rotation()), Random(41).field(mesh.nodes().size(), 2.5e-3));
  NodeField velocities;
  std::vector<double> positions4, velocities4;
  std::vector<double> scale, pressure, offset, force, tangent, volume_gradient, dilatation, isochoric, volumetric,
      least;
  ElasticSweep job;

  static std::vector<double> four_per_node(const NodeField& field) {
    std::vector<double> four;
    for (std::size_t k = 0; k < field.size(); ++k) {
      four.push_back(field[k]);
      if (k % 3 == 2) four.push_back(1e300);  // not to be used
    }
    return four;
  }

  explicit Sweep(const Yeoh& law, bool mean_dilatation, bool viscous = false, Kernels kernels = {}) {
    const std::size_t padded = batches->count() * lanes;
    Random random(42);
    for (std::size_t e = 0; e < padded; ++e) {
      scale.push_back(random(1.0, 8.0));
      pressure.push_back(random(-2e4, 2e4));
    }
    offset.assign(padded, 0.0);
    velocities = random.field(positions.size(), 0.1);
    for (auto* field : {&dilatation, &isochoric, &volumetric, &least}) field->assign(padded, -1.0);
    force.assign(padded * element_force_size, -1.0);
    tangent.assign(padded * element_tangent_size, -1.0);
    volume_gradient.assign(padded * volume_gradient_size, -1.0);
    positions4 = four_per_node(positions);
    velocities4 = four_per_node(velocities);
    job.batches = batches->linear.data();
    job.law = law;
    job.mean_dilatation = mean_dilatation;
    job.positions = positions4.data();
    job.isochoric_scale = scale.data();
    job.volumetric_scale = 1.7;
    job.pressure = pressure.data();
    job.pressure_offset = offset.data();
    if (viscous) job.velocities = velocities4.data();
    job.viscosity = 0.03;
    job.viscous_share = 6.0;
    job.force = force.data();
    job.tangent = tangent.data();
    job.volume_gradient = volume_gradient.data();
    job.dilatation = dilatation.data();
    job.isochoric_energy = isochoric.data();
    job.volumetric_energy = volumetric.data();
    job.least_jacobian = least.data();
    kernels.forces(job, 0, static_cast<int>(batches->count()));
    kernels.tangents(job, 0, static_cast<int>(batches->count()));
  }
};

/// Forces on the corners of an element, three by three; the fourth entries are zero.
Force24 corner_forces(const Sweep& s, std::size_t element) {
  const Eigen::Map<const Eigen::Matrix<double, 4, 8>> corners(s.force.data() + element * element_force_size);
  CHECK(corners.row(3).isZero(0.0));
  Eigen::Matrix<double, 3, 8> three = corners.topRows<3>();
  return Eigen::Map<Force24>(three.data());
}

const Yeoh isochoric_part{1037.0, 486.0, 0.0}, volumetric_part{0.0, 0.0, 1.0369e6}, tissue{1037.0, 486.0, 1.0369e6};

void compare(const Sweep& s, const Yeoh& law, bool mean_dilatation) {
  for (Index e = 0; e < s.mesh.element_count(); ++e) {
    const auto k = static_cast<std::size_t>(e);
    const ElementResult r =
        reference_element(s.mesh, e, s.positions, law, {s.scale[k], 1.7, s.pressure[k]}, mean_dilatation);
    const Force24 force = corner_forces(s, k);
    const Matrix24 tangent = unpacked(s.tangent.data() + k * element_tangent_size);
    CHECK_WITHIN(worst_entry(force, r.force), 2e-13);  // rounding of theta - 1
    CHECK_WITHIN(worst_entry(tangent, r.tangent), 2e-14);
    CHECK(tangent != r.tangent);
    const Eigen::Map<const Force24> gradient(s.volume_gradient.data() + k * volume_gradient_size);
    CHECK_WITHIN(worst_entry(gradient, r.volume_gradient), 5e-15);
    CHECK_WITHIN(std::abs(s.dilatation[k] - r.dilatation), 5e-15);
    CHECK_WITHIN(std::abs(s.least[k] - r.least_jacobian), 5e-15);
    if (law.c10 > 0.0) CHECK_WITHIN(std::abs(s.isochoric[k] / r.isochoric_energy - 1.0), 1e-13);
    if (law.kappa > 0.0)
      CHECK_WITHIN(std::abs(s.volumetric[k] / r.volumetric_energy - 1.0), 5e-13);  // 2 eps / (theta - 1)
  }
}

}  // namespace

TEST_CASE("element kernel: mean dilatation against a straightforward element, entry by entry") {
  for (const Yeoh& law : {isochoric_part, volumetric_part, tissue}) compare(Sweep(law, true), law, true);
}

TEST_CASE("element kernel: plain Q1 against a straightforward element, entry by entry") {
  for (const Yeoh& law : {isochoric_part, volumetric_part, tissue}) compare(Sweep(law, false), law, false);
}

TEST_CASE("element kernel: the baseline and the widest instruction set agree to rounding") {
  if (!has_avx2()) return;
  for (const bool mean_dilatation : {true, false})
    for (const bool viscous : {false, true}) {
      const Sweep wide(tissue, mean_dilatation, viscous);
      const Sweep base(tissue, mean_dilatation, viscous, {&baseline::sweep_forces, &baseline::sweep_tangents});
      CHECK_WITHIN(worst_entry(wide.force, base.force), 1e-13);  // fused multiply-add rounds once instead of twice
      CHECK_WITHIN(worst_entry(wide.tangent, base.tangent), 1e-14);
      CHECK_WITHIN(worst_entry(wide.dilatation, base.dilatation), 5e-15);
      CHECK_WITHIN(worst_entry(wide.isochoric, base.isochoric), 1e-13);
      CHECK_WITHIN(worst_entry(wide.volumetric, base.volumetric), 2e-13);
    }
}

}  // namespace glossa::test
