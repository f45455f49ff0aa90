// A sum of weight g g' with sparse g: what is added to a matrix without widening the pattern of its factor.
#pragma once

#include <vector>

#include "core/types.hpp"

namespace glossa {

struct RankOnes {
  std::vector<double> weight;
  std::vector<Index> start{0};  ///< of each g among the entries
  std::vector<Index> row;
  std::vector<double> value;

  void clear() { *this = RankOnes(); }
  /// Ends the g whose entries were pushed last.
  void close(double its_weight) {
    weight.push_back(its_weight);
    start.push_back(static_cast<Index>(row.size()));
  }
  /// product += sum of weight g (g' x).
  void add_product(const Vector& x, Vector& product) const {
    for (std::size_t k = 0; k < weight.size(); ++k) {
      const auto begin = static_cast<std::size_t>(start[k]), end = static_cast<std::size_t>(start[k + 1]);
      double along = 0.0;
      for (std::size_t e = begin; e < end; ++e) along += value[e] * x(row[e]);
      along *= weight[k];
      for (std::size_t e = begin; e < end; ++e) product(row[e]) += along * value[e];
    }
  }
};

}  // namespace glossa
