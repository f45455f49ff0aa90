#include "contact/spline_grid.hpp"

#include <algorithm>
#include <utility>

#include "core/parallel.hpp"

namespace glossa {
namespace {

/// Values and derivatives (with respect to t) of the four B-splines over one cell, 0 <= t <= 1.
template <int derivatives>
struct Weights {
  std::array<double, 4> w, d{}, dd{};

  explicit Weights(double t) {
    const double s = 1.0 - t, t2 = t * t, s2 = s * s;
    w = {s2 * s / 6.0, 2.0 / 3.0 - t2 * (1.0 - 0.5 * t), 2.0 / 3.0 - s2 * (1.0 - 0.5 * s), t2 * t / 6.0};
    if constexpr (derivatives > 0) d = {-0.5 * s2, t * (1.5 * t - 2.0), s * (2.0 - 1.5 * s), 0.5 * t2};
    if constexpr (derivatives > 1) dd = {s, 3.0 * t - 2.0, 3.0 * s - 2.0, t};
  }
};

/// Along one axis of rows that are `step` apart: out = (-before + 8 here - after) / 6, for four rows of six.
void quasi_interpolate(const double* in, std::size_t step, std::size_t count, double* out) {
  for (std::size_t row = 0; row < 4; ++row)
    for (std::size_t k = 0; k < count; ++k) {
      const double* here = in + (row + 1) * step + k;
      out[row * step + k] = (8.0 * here[0] - *(here - step) - here[step]) / 6.0;
    }
}

/// Coefficients of a brick from its samples and those around.
void coefficients(const BrickValues<double>::Halo& samples, double* out) {
  std::array<double, 144> slabs;  // 4 x 6 x 6
  std::array<double, 24> rows;    // 4 x 6
  quasi_interpolate(samples.data(), 36, 36, slabs.data());
  for (std::size_t i = 0; i < 4; ++i) {
    quasi_interpolate(slabs.data() + 36 * i, 6, 6, rows.data());
    for (std::size_t j = 0; j < 4; ++j) quasi_interpolate(rows.data() + 6 * j, 1, 1, out + 16 * i + 4 * j);
  }
}

/// Bricks that have another block of samples next to them or are not uniform.
std::vector<int> varying(const LatticeBricks& bricks, const std::vector<Index>& block_of, Index shared) {
  std::vector<int> result;
  for (int number = 0; number < bricks.count(); ++number) {
    const Index own = block_of[static_cast<std::size_t>(number)];
    bool varies = own >= shared;
    if (!varies)
      bricks.around(number, [&](int other) { varies = varies || block_of[static_cast<std::size_t>(other)] != own; });
    if (varies) result.push_back(number);
  }
  return result;
}

}  // namespace

SplineGrid::SplineGrid(const LatticeBricks& bricks, std::vector<Index> block_of, const BrickValues<double>& samples,
                       int threads)
    : bricks_(bricks), per_spacing_(1.0 / bricks.lattice().spacing), block_of_(std::move(block_of)) {
  const std::vector<int> numbers = varying(bricks, block_of_, samples.shared);
  const auto shared = static_cast<std::size_t>(samples.shared);
  coefficients_.shared = samples.shared;
  coefficients_.values.resize(LatticeBricks::volume * (shared + numbers.size()));
  std::copy_n(samples.values.begin(), LatticeBricks::volume * shared, coefficients_.values.begin());
  parallel_ranges(static_cast<int>(numbers.size()), threads, [&](int begin, int end) {
    BrickValues<double>::Halo halo;
    for (int n = begin; n < end; ++n) {
      samples.halo(bricks, block_of_, numbers[static_cast<std::size_t>(n)], halo);
      coefficients(halo, coefficients_.block(samples.shared + n));
    }
  });
  for (std::size_t n = 0; n < numbers.size(); ++n)
    block_of_[static_cast<std::size_t>(numbers[n])] = static_cast<Index>(shared + n);
}

bool SplineGrid::covers(const Vector3& x) const {
  const Vector3 t = (x - lattice().origin) * per_spacing_;
  bool inside = true;
  for (int axis = 0; axis < 3; ++axis)
    inside = inside && t[axis] >= 1.0 && t[axis] < lattice().size[static_cast<std::size_t>(axis)] - 2;
  return inside;
}

void SplineGrid::gather(SplineCell& cell) const {
  constexpr int edge = LatticeBricks::edge;
  // The blocks that hold the coefficients: one or two along each axis, from the one of the first coefficient.
  std::array<int, 3> brick, first;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    brick[axis] = (cell.cell[axis] - 1) / edge;
    first[axis] = (cell.cell[axis] - 1) % edge;
  }
  std::array<const double*, 8> blocks;
  bool same = true;
  for (int n = 0; n < 8; ++n) {
    const auto place = [&](std::size_t axis, int after) { return brick[axis] + (first[axis] > 0 ? after : 0); };
    const int number = bricks_.number_of(place(0, n / 4), place(1, n / 2 % 2), place(2, n % 2));
    const Index block = block_of_[static_cast<std::size_t>(number)];
    const auto place_in_list = static_cast<std::size_t>(n);
    blocks[place_in_list] = coefficients_.block(block);
    same = same && block < coefficients_.shared && blocks[place_in_list] == blocks[0];
  }
  cell.uniform = same;
  cell.coefficients[0] = *blocks[0];
  if (same) return;
  double* c = cell.coefficients.data();
  for (int i = first[0]; i < first[0] + 4; ++i)
    for (int j = first[1]; j < first[1] + 4; ++j) {
      const double* const* pair = blocks.data() + 4 * (i / edge) + 2 * (j / edge);
      const int row = edge * (edge * (i % edge) + j % edge);
      for (int k = first[2]; k < first[2] + 4; ++k) *c++ = pair[k / edge][row + k % edge];
    }
}

template <int derivatives>
double SplineGrid::evaluate(const Vector3& x, SplineCell& kept, Vector3* gradient, Matrix3* hessian) const {
  const Vector3 t = (x - lattice().origin) * per_spacing_;
  const std::array<int, 3> cell{static_cast<int>(t.x()), static_cast<int>(t.y()), static_cast<int>(t.z())};
  if (cell != kept.cell) {
    kept.cell = cell;
    gather(kept);
  }
  const std::array<double, 64>& c = kept.coefficients;
  if (kept.uniform) {
    if constexpr (derivatives > 0) gradient->setZero();
    if constexpr (derivatives > 1) hessian->setZero();
    return c[0];
  }
  const Weights<derivatives> wx(t.x() - cell[0]), wy(t.y() - cell[1]), wz(t.z() - cell[2]);
  // Sums named by the derivatives they carry: f, and z, y, x for one of each.
  double f = 0.0, fz = 0.0, fy = 0.0, fx = 0.0, fzz = 0.0, fyz = 0.0, fyy = 0.0, fxz = 0.0, fxy = 0.0, fxx = 0.0;
  const double* row = c.data();
  for (std::size_t i = 0; i < 4; ++i) {
    double p = 0.0, pz = 0.0, py = 0.0, pzz = 0.0, pyz = 0.0, pyy = 0.0;
    for (std::size_t j = 0; j < 4; ++j, row += 4) {
      const auto along = [&](const std::array<double, 4>& w) {
        return w[0] * row[0] + w[1] * row[1] + w[2] * row[2] + w[3] * row[3];
      };
      const double r = along(wz.w);
      p += wy.w[j] * r;
      if constexpr (derivatives > 0) {
        const double rz = along(wz.d);
        pz += wy.w[j] * rz;
        py += wy.d[j] * r;
        if constexpr (derivatives > 1) {
          pzz += wy.w[j] * along(wz.dd);
          pyz += wy.d[j] * rz;
          pyy += wy.dd[j] * r;
        }
      }
    }
    f += wx.w[i] * p;
    if constexpr (derivatives > 0) {
      fz += wx.w[i] * pz;
      fy += wx.w[i] * py;
      fx += wx.d[i] * p;
    }
    if constexpr (derivatives > 1) {
      fzz += wx.w[i] * pzz;
      fyz += wx.w[i] * pyz;
      fyy += wx.w[i] * pyy;
      fxz += wx.d[i] * pz;
      fxy += wx.d[i] * py;
      fxx += wx.dd[i] * p;
    }
  }
  if constexpr (derivatives > 0) *gradient = per_spacing_ * Vector3(fx, fy, fz);
  if constexpr (derivatives > 1) {
    *hessian << fxx, fxy, fxz, fxy, fyy, fyz, fxz, fyz, fzz;
    *hessian *= per_spacing_ * per_spacing_;
  }
  return f;
}

double SplineGrid::value(const Vector3& x) const {
  SplineCell cell;
  return evaluate<0>(x, cell, nullptr, nullptr);
}
double SplineGrid::value(const Vector3& x, Vector3& gradient) const {
  SplineCell cell;
  return evaluate<1>(x, cell, &gradient, nullptr);
}
double SplineGrid::value(const Vector3& x, Vector3& gradient, Matrix3& hessian) const {
  SplineCell cell;
  return evaluate<2>(x, cell, &gradient, &hessian);
}
double SplineGrid::value(const Vector3& x, Vector3& gradient, SplineCell& cell) const {
  return evaluate<1>(x, cell, &gradient, nullptr);
}

}  // namespace glossa
