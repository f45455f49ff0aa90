#include "muscle/macrofibre.hpp"

namespace glossa {
namespace {

template <class Visit>
void for_segments(const Macrofibres& fibres, Index f, Visit&& visit) {
  const Index* path = fibres.nodes.begin(f);
  const Index count = fibres.nodes.length(f);
  for (Index k = 0; k + 1 < count; ++k) visit(k, path[k], path[k + 1]);
}

}  // namespace

double fibre_length(const Macrofibres& fibres, Index f, const NodeField& positions) {
  double sum = 0.0;
  for_segments(fibres, f, [&](Index, Index a, Index b) { sum += (at(positions, b) - at(positions, a)).norm(); });
  return sum * fibres.length_factor[static_cast<std::size_t>(f)];
}

double fibre_rate(const Macrofibres& fibres, Index f, const NodeField& positions, const NodeField& velocities) {
  double sum = 0.0;
  for_segments(fibres, f, [&](Index, Index a, Index b) {
    const Vector3 d = at(positions, b) - at(positions, a);
    sum += d.dot(at(velocities, b) - at(velocities, a)) / d.norm();
  });
  return sum * fibres.length_factor[static_cast<std::size_t>(f)];
}

void fibre_gradient(const Macrofibres& fibres, Index f, const NodeField& positions, std::vector<Vector3>& gradient) {
  gradient.assign(static_cast<std::size_t>(fibres.nodes.length(f)), Vector3::Zero());
  for_segments(fibres, f, [&](Index k, Index a, Index b) {
    const Vector3 n = (at(positions, b) - at(positions, a)).normalized();
    gradient[static_cast<std::size_t>(k)] -= n;
    gradient[static_cast<std::size_t>(k) + 1] += n;
  });
}

Matrix3 segment_curvature(const Vector3& a, const Vector3& b) {
  const Vector3 d = b - a;
  const double length = d.norm();
  const Vector3 n = d / length;
  return (Matrix3::Identity() - n * n.transpose()) / length;
}

}  // namespace glossa
