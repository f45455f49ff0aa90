#include "effect/inertia.hpp"

#include <map>

namespace glossa {

Inertia::Inertia(const Cells& elements, Index node_count, const std::vector<double>& element_masses,
                 const std::vector<PointMass>& points) {
  std::vector<std::map<Index, double>> rows(static_cast<std::size_t>(node_count));
  std::size_t pair = 0;
  for (std::size_t e = 0; e < elements.count(); ++e) {
    const Index* nodes = elements.begin(e);
    for (std::size_t b = 0; b < elements.size; ++b)
      for (std::size_t a = 0; a <= b; ++a, ++pair) {
        rows[static_cast<std::size_t>(nodes[a])][nodes[b]] += element_masses[pair];
        if (a != b) rows[static_cast<std::size_t>(nodes[b])][nodes[a]] += element_masses[pair];
      }
  }
  for (const PointMass& point : points) rows[static_cast<std::size_t>(point.node)][point.node] += point.mass;
  row_start_.assign(1, 0);
  for (const auto& row : rows) {
    for (const auto& [node, mass] : row) {
      column_.push_back(node);
      mass_.push_back(mass);
    }
    row_start_.push_back(static_cast<Index>(column_.size()));
  }
}

void Inertia::multiply(double scale, const NodeField& x, NodeField& product) const {
  for (std::size_t n = 0; n + 1 < row_start_.size(); ++n) {
    double sum[3] = {0.0, 0.0, 0.0};
    for (Index k = row_start_[n]; k < row_start_[n + 1]; ++k) {
      const double m = mass_[static_cast<std::size_t>(k)];
      const double* from = x.data() + 3 * static_cast<std::size_t>(column_[static_cast<std::size_t>(k)]);
      for (int i = 0; i < 3; ++i) sum[i] += m * from[i];
    }
    for (std::size_t i = 0; i < 3; ++i) product[3 * n + i] += scale * sum[i];
  }
}

void Inertia::add_force(const Trial& trial, NodeField& force) {
  if (trial.mass_rate != 0.0) multiply(trial.mass_rate, trial.velocities, force);
}

}  // namespace glossa
