#include "effect/elasticity_kernel.hpp"

#include "core/instruction_set.hpp"
#include "effect/elasticity.hpp"
#include "reference_element.hpp"

namespace glossa::test {
namespace {

using Kernel = void (*)(const ElasticSweep&, int, int);

/// Everything that one sweep writes, for a deformed, distorted mesh of six elements: the last batch is half filled.
struct Sweep {
  HexMesh mesh = block(3, 2, 1, 0.2);
  std::shared_ptr<const RestBatches> batches = rest_batches(mesh);
  NodeField positions = sum(mapped(mesh.nodes(), rotation()), Random(41).field(mesh.nodes().size(), 2.5e-3));
  NodeField velocities;
  std::vector<double> scale, pressure, offset, force, tangent, volume_gradient, dilatation, isochoric, volumetric,
      least;
  ElasticSweep job;

  Sweep(const Yeoh& law, bool mean_dilatation, bool with_tangent, bool viscous = false,
        Kernel kernel = &sweep_elements) {
    const std::size_t padded = batches->size() * lanes;
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
    volume_gradient.assign(padded * element_force_size, -1.0);
    job.batches = batches->data();
    job.law = law;
    job.mean_dilatation = mean_dilatation;
    job.positions = positions.data();
    job.isochoric_scale = scale.data();
    job.volumetric_scale = 1.7;
    job.pressure = pressure.data();
    job.pressure_offset = offset.data();
    if (viscous) job.velocities = velocities.data();
    job.viscosity = 0.03;
    job.viscous_share = 6.0;
    job.force = force.data();
    job.tangent = with_tangent ? tangent.data() : nullptr;
    job.volume_gradient = volume_gradient.data();
    job.dilatation = dilatation.data();
    job.isochoric_energy = isochoric.data();
    job.volumetric_energy = volumetric.data();
    job.least_jacobian = least.data();
    kernel(job, 0, static_cast<int>(batches->size()));
  }
};

const Yeoh isochoric_part{1037.0, 486.0, 0.0}, volumetric_part{0.0, 0.0, 1.0369e6}, tissue{1037.0, 486.0, 1.0369e6};

void compare(const Sweep& s, const Yeoh& law, bool mean_dilatation) {
  for (Index e = 0; e < s.mesh.element_count(); ++e) {
    const auto k = static_cast<std::size_t>(e);
    const ElementResult r =
        reference_element(s.mesh, e, s.positions, law, {s.scale[k], 1.7, s.pressure[k]}, mean_dilatation);
    const Eigen::Map<const Force24> force(s.force.data() + k * element_force_size);
    const Matrix24 tangent = unpacked(s.tangent.data() + k * element_tangent_size);
    CHECK_WITHIN(worst_entry(force, r.force), 2e-13);  // rounding of theta - 1
    CHECK_WITHIN(worst_entry(tangent, r.tangent), 2e-14);
    CHECK(tangent != r.tangent);
    const Eigen::Map<const Force24> gradient(s.volume_gradient.data() + k * element_force_size);
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
  for (const Yeoh& law : {isochoric_part, volumetric_part, tissue}) compare({law, true, true}, law, true);
}

TEST_CASE("element kernel: plain Q1 against a straightforward element, entry by entry") {
  for (const Yeoh& law : {isochoric_part, volumetric_part, tissue}) compare({law, false, true}, law, false);
}

TEST_CASE("element kernel: the path without tangent gives the same forces and touches nothing else") {
  for (const bool mean_dilatation : {true, false})
    for (const bool viscous : {false, true}) {
      const Sweep with(tissue, mean_dilatation, true, viscous), without(tissue, mean_dilatation, false, viscous);
      CHECK_WITHIN(worst_entry(without.force, with.force), 1e-15);
      CHECK_WITHIN(worst_entry(without.isochoric, with.isochoric), 1e-15);
      CHECK(without.tangent == std::vector<double>(without.tangent.size(), -1.0));
    }
}

TEST_CASE("element kernel: the baseline and the widest instruction set agree to rounding") {
  if (!has_avx2()) return;
  for (const bool mean_dilatation : {true, false})
    for (const bool viscous : {false, true}) {
      const Sweep wide(tissue, mean_dilatation, true, viscous);
      const Sweep base(tissue, mean_dilatation, true, viscous, &baseline::sweep_elements);
      CHECK_WITHIN(worst_entry(wide.force, base.force), 1e-13);  // fused multiply-add rounds once instead of twice
      CHECK_WITHIN(worst_entry(wide.tangent, base.tangent), 1e-14);
      CHECK_WITHIN(worst_entry(wide.dilatation, base.dilatation), 5e-15);
      CHECK_WITHIN(worst_entry(wide.isochoric, base.isochoric), 1e-13);
      CHECK_WITHIN(worst_entry(wide.volumetric, base.volumetric), 2e-13);
    }
}

}  // namespace glossa::test
