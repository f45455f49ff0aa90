#include "muscle/macrofibre.hpp"

#include <algorithm>

#include "fibres.hpp"

namespace glossa::test {
namespace {

struct Deformed {
  HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  Macrofibres fibres = three_fibres(mesh);
  NodeField positions = sum(mesh.nodes(), Random(21).field(mesh.nodes().size(), 2e-3));
  explicit Deformed(bool soft = true) {
    if (soft) soften_segments(fibres, mesh.nodes());
  }
};

}  // namespace

TEST_CASE("macrofibre: length is the sum over segments times the length factor") {
  const HexMesh mesh = block(2, 2, 2);
  Macrofibres fibres;
  add_fibre(fibres, 0, {0, 1, 10}, 1.0, 1.0, mesh.nodes());
  add_fibre(fibres, 0, {0, 13}, 1.0, 2.0, mesh.nodes());
  CHECK_WITHIN(std::abs(fibres.rest_length[0] - 0.02), 1e-17);
  CHECK_WITHIN(std::abs(fibres.rest_length[1] - 2.0 * std::sqrt(3.0) * 0.01), 1e-17);
}

TEST_CASE("macrofibre: gradient of the length against differences, fixed outside point included") {
  const Deformed d;
  for (Index f = 0; f < d.fibres.count(); ++f) {
    std::vector<Vector3> gradient;
    fibre_gradient(d.fibres, f, d.positions, gradient);
    REQUIRE(gradient.size() == static_cast<std::size_t>(d.fibres.nodes.length(f)));
    for (std::size_t a = 0; a < gradient.size(); ++a)
      for (Eigen::Index i = 0; i < 3; ++i) {
        const auto component = static_cast<std::size_t>(3 * d.fibres.nodes.begin(f)[a] + i);
        const double reference = slope(
            [&](double h) {
              NodeField moved = d.positions;
              moved[component] += h;
              return fibre_length(d.fibres, f, moved) / d.fibres.length_factor[static_cast<std::size_t>(f)];
            },
            1e-5);
        CHECK_WITHIN(std::abs(gradient[a](i) - reference), 5e-11);  // truncation (h / l)^4
      }
  }
}

TEST_CASE("macrofibre: rate is the derivative of the length along the motion") {
  const Deformed d;
  const NodeField velocities = Random(22).field(d.positions.size(), 0.1);
  for (Index f = 0; f < d.fibres.count(); ++f) {
    const double reference =
        slope([&](double t) { return fibre_length(d.fibres, f, sum(d.positions, velocities, t)); }, 1e-4);
    CHECK_WITHIN(std::abs(fibre_rate(d.fibres, f, d.positions, velocities) / reference - 1.0), 1e-10);  // truncation
  }
}

TEST_CASE("macrofibre: curvature of a segment is the derivative of its direction") {
  for (const bool soft : {false, true}) {
    const Deformed d(soft);
    const Index far_end = d.fibres.nodes.begin(0)[2];
    Matrix3 reference;
    for (Eigen::Index i = 0; i < 3; ++i)
      reference.col(i) = derivative(
          [&](double h) {
            NodeField moved = d.positions;
            moved[static_cast<std::size_t>(3 * far_end + i)] += h;
            return fibre_segment(d.fibres, 0, 1, moved).direction;
          },
          1e-5);
    CHECK_WITHIN(worst_entry(fibre_segment(d.fibres, 0, 1, d.positions).curvature(), reference), 3e-11);  // (h / l)^4
  }
}

TEST_CASE("macrofibre: softening keeps rest lengths, changes little, and stops a collapsed segment from pulling") {
  const Deformed sharp(false), soft(true);
  for (Index f = 0; f < 3; ++f) {
    const double rest = sharp.fibres.rest_length[static_cast<std::size_t>(f)];
    CHECK_WITHIN(std::abs(fibre_length(soft.fibres, f, soft.mesh.nodes()) / rest - 1.0), 1e-15);
    const double change = fibre_length(soft.fibres, f, soft.positions) - fibre_length(sharp.fibres, f, soft.positions);
    CHECK_WITHIN(std::abs(change) / rest, 1e-4);
  }
  NodeField collapsed = soft.positions;
  std::copy_n(collapsed.begin() + 3 * 13, 3, collapsed.begin() + 3 * 23);
  const Segment segment = fibre_segment(soft.fibres, 0, 1, collapsed);
  CHECK(segment.direction.isZero(0.0));
  CHECK(segment.curvature().allFinite());
}

}  // namespace glossa::test
