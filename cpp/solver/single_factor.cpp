#include "solver/single_factor.hpp"

#include <algorithm>

#include "core/instruction_set.hpp"

namespace glossa {
namespace {

constexpr Index width = 8;

Index padded(Index n) {
  return (n + width - 1) / width * width;
}

}  // namespace

void SingleFactor::copy(std::size_t count, const Index* super, const Index* row_start, const Index* rows,
                        const Index* value_start, const double* values) {
  supernodes_.clear();
  rows_.clear();
  std::size_t size = 0;
  Index longest = width;
  for (std::size_t k = 0; k < count; ++k) {
    Supernode s;
    s.first = super[k];
    s.columns = super[k + 1] - super[k];
    s.below = row_start[k + 1] - row_start[k] - s.columns;
    s.padded_columns = padded(s.columns);
    s.padded_below = padded(s.below);
    s.row_start = static_cast<Index>(rows_.size());
    rows_.insert(rows_.end(), rows + row_start[k] + s.columns, rows + row_start[k + 1]);
    s.diagonal = size;
    size += static_cast<std::size_t>(s.columns) * static_cast<std::size_t>(s.padded_columns);
    s.off = size;
    size += static_cast<std::size_t>(s.columns) * static_cast<std::size_t>(s.padded_below);
    longest = std::max({longest, s.padded_columns, s.padded_below});
    supernodes_.push_back(s);
  }
  values_.assign(size, 0.0f);
  work_.assign(2 * static_cast<std::size_t>(longest), 0.0f);
  for (std::size_t k = 0; k < count; ++k) {
    const Supernode& s = supernodes_[k];
    const Index lead = s.columns + s.below;
    for (Index j = 0; j < s.columns; ++j) {
      const double* from = values + value_start[k] + static_cast<std::ptrdiff_t>(j) * lead;
      float* block =
          values_.data() + s.diagonal + static_cast<std::size_t>(j) * static_cast<std::size_t>(s.padded_columns);
      float* off = values_.data() + s.off + static_cast<std::size_t>(j) * static_cast<std::size_t>(s.padded_below);
      block[j] = static_cast<float>(1.0 / from[j]);
      for (Index i = j + 1; i < s.columns; ++i) block[i] = static_cast<float>(from[i]);
      for (Index i = 0; i < s.below; ++i) off[i] = static_cast<float>(from[s.columns + i]);
    }
  }
}

void SingleFactor::solve(Vector& x) {
  // Scaled, so that neither tiny residuals nor large loads leave the range of single precision.
  const double size = x.size() > 0 ? x.cwiseAbs().maxCoeff() : 0.0;
  if (!(size > 0.0)) return;
  x_.resize(static_cast<std::size_t>(x.size()));
  for (std::size_t k = 0; k < x_.size(); ++k) x_[k] = static_cast<float>(x(static_cast<Eigen::Index>(k)) / size);
  const SingleFactorView view{supernodes_.data(), supernodes_.size(), rows_.data(),
                              values_.data(),     work_.data(),       work_.data() + work_.size() / 2};
#ifdef GLOSSA_HAS_AVX2_KERNEL
  if (has_avx2())
    avx2::solve_single(view, x_.data());
  else
#endif
    baseline::solve_single(view, x_.data());
  for (std::size_t k = 0; k < x_.size(); ++k) x(static_cast<Eigen::Index>(k)) = size * static_cast<double>(x_[k]);
}

}  // namespace glossa
