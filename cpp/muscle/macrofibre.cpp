#include "muscle/macrofibre.hpp"

#include <cmath>

namespace glossa {
namespace {

constexpr double softening = 0.01;  // of the rest length of a segment
const double added_at_rest = std::sqrt(1.0 + softening * softening) - 1.0;

}  // namespace

Segment fibre_segment(const Macrofibres& fibres, Index f, Index k, const NodeField& positions) {
  const auto entry = static_cast<std::size_t>(fibres.nodes.start[static_cast<std::size_t>(f)] + k);
  const Vector3 d = at(positions, fibres.nodes.values[entry + 1]) - at(positions, fibres.nodes.values[entry]);
  const double rest = fibres.segment_rest.empty() ? 0.0 : fibres.segment_rest[entry];
  const double divisor = std::sqrt(d.squaredNorm() + softening * softening * rest * rest);
  return {d / divisor, divisor - added_at_rest * rest, divisor};
}

void soften_segments(Macrofibres& fibres, const NodeField& rest) {
  fibres.segment_rest.assign(fibres.nodes.values.size(), 0.0);
  for (Index f = 0; f < fibres.count(); ++f)
    for (Index k = 0; k + 1 < fibres.nodes.length(f); ++k) {
      const auto entry = static_cast<std::size_t>(fibres.nodes.start[static_cast<std::size_t>(f)] + k);
      fibres.segment_rest[entry] =
          (at(rest, fibres.nodes.values[entry + 1]) - at(rest, fibres.nodes.values[entry])).norm();
    }
}

double fibre_length(const Macrofibres& fibres, Index f, const NodeField& positions) {
  double sum = 0.0;
  for (Index k = 0; k + 1 < fibres.nodes.length(f); ++k) sum += fibre_segment(fibres, f, k, positions).length;
  return sum * fibres.length_factor[static_cast<std::size_t>(f)];
}

double fibre_rate(const Macrofibres& fibres, Index f, const NodeField& positions, const NodeField& velocities) {
  const Index* path = fibres.nodes.begin(f);
  double sum = 0.0;
  for (Index k = 0; k + 1 < fibres.nodes.length(f); ++k)
    sum += fibre_segment(fibres, f, k, positions).direction.dot(at(velocities, path[k + 1]) - at(velocities, path[k]));
  return sum * fibres.length_factor[static_cast<std::size_t>(f)];
}

void fibre_gradient(const Macrofibres& fibres, Index f, const NodeField& positions, std::vector<Vector3>& gradient) {
  gradient.assign(static_cast<std::size_t>(fibres.nodes.length(f)), Vector3::Zero());
  for (Index k = 0; k + 1 < fibres.nodes.length(f); ++k) {
    const Vector3 n = fibre_segment(fibres, f, k, positions).direction;
    gradient[static_cast<std::size_t>(k)] -= n;
    gradient[static_cast<std::size_t>(k) + 1] += n;
  }
}

}  // namespace glossa
