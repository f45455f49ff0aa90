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

/// One plane of points i, or one row of each plane: out = (-before + 8 here - after) / 6, elementwise.
void quasi_interpolate(const double* before, const double* here, const double* after, std::size_t count, double* out) {
  for (std::size_t k = 0; k < count; ++k) out[k] = (8.0 * here[k] - before[k] - after[k]) / 6.0;
}

}  // namespace

SplineGrid::SplineGrid(const Lattice& lattice, std::vector<double> samples, int threads)
    : lattice_(lattice), per_spacing_(1.0 / lattice.spacing), coefficients_(samples.size()) {
  const auto row = static_cast<std::size_t>(lattice.size[2]);
  const std::size_t plane = row * static_cast<std::size_t>(lattice.size[1]);
  // Samples beyond the lattice repeat the last ones.
  const auto neighbour = [&](int i, int step, std::size_t axis) {
    return std::clamp(i + step, 0, lattice.size[axis] - 1);
  };
  parallel_ranges(lattice.size[0], threads, [&](int begin, int end) {
    for (int i = begin; i < end; ++i)
      quasi_interpolate(samples.data() + lattice.index(neighbour(i, -1, 0), 0, 0),
                        samples.data() + lattice.index(i, 0, 0),
                        samples.data() + lattice.index(neighbour(i, 1, 0), 0, 0), plane,
                        coefficients_.data() + lattice.index(i, 0, 0));
  });
  std::swap(samples, coefficients_);
  parallel_ranges(lattice.size[0], threads, [&](int begin, int end) {
    std::vector<double> line(row);
    for (int i = begin; i < end; ++i)
      for (int j = 0; j < lattice.size[1]; ++j) {
        quasi_interpolate(samples.data() + lattice.index(i, neighbour(j, -1, 1), 0),
                          samples.data() + lattice.index(i, j, 0),
                          samples.data() + lattice.index(i, neighbour(j, 1, 1), 0), row, line.data());
        double* out = coefficients_.data() + lattice.index(i, j, 0);
        quasi_interpolate(line.data(), line.data() + 1, line.data() + 2, row - 2, out + 1);
        quasi_interpolate(line.data(), line.data(), line.data() + 1, 1, out);
        quasi_interpolate(line.data() + row - 2, line.data() + row - 1, line.data() + row - 1, 1, out + row - 1);
      }
  });
}

bool SplineGrid::covers(const Vector3& x) const {
  const Vector3 t = (x - lattice_.origin) * per_spacing_;
  bool inside = true;
  for (int axis = 0; axis < 3; ++axis)
    inside = inside && t[axis] >= 1.0 && t[axis] < lattice_.size[static_cast<std::size_t>(axis)] - 2;
  return inside;
}

template <int derivatives>
double SplineGrid::evaluate(const Vector3& x, Vector3* gradient, Matrix3* hessian) const {
  const Vector3 t = (x - lattice_.origin) * per_spacing_;
  const std::array<int, 3> cell{static_cast<int>(t.x()), static_cast<int>(t.y()), static_cast<int>(t.z())};
  const Weights<derivatives> wx(t.x() - cell[0]), wy(t.y() - cell[1]), wz(t.z() - cell[2]);
  const auto row_step = static_cast<std::size_t>(lattice_.size[2]);
  const std::size_t plane_step = row_step * static_cast<std::size_t>(lattice_.size[1]);
  const double* plane = coefficients_.data() + lattice_.index(cell[0] - 1, cell[1] - 1, cell[2] - 1);
  // Sums named by the derivatives they carry: f, and z, y, x for one of each.
  double f = 0.0, fz = 0.0, fy = 0.0, fx = 0.0, fzz = 0.0, fyz = 0.0, fyy = 0.0, fxz = 0.0, fxy = 0.0, fxx = 0.0;
  for (std::size_t i = 0; i < 4; ++i, plane += plane_step) {
    double p = 0.0, pz = 0.0, py = 0.0, pzz = 0.0, pyz = 0.0, pyy = 0.0;
    const double* row = plane;
    for (std::size_t j = 0; j < 4; ++j, row += row_step) {
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
  return evaluate<0>(x, nullptr, nullptr);
}
double SplineGrid::value(const Vector3& x, Vector3& gradient) const {
  return evaluate<1>(x, &gradient, nullptr);
}
double SplineGrid::value(const Vector3& x, Vector3& gradient, Matrix3& hessian) const {
  return evaluate<2>(x, &gradient, &hessian);
}

}  // namespace glossa
