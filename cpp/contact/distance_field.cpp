#include "contact/distance_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "contact/wall_distance.hpp"
#include "core/error.hpp"

namespace glossa {
namespace {

constexpr double clip_width = 1.5;  // half width of the smooth clip, in spacings
constexpr double least_band = 4.0;  // in spacings: the clip must leave the surface alone
constexpr double most_points = 4e7;
constexpr double error_percentile = 0.95;

void check(const DistanceFieldOptions& options) {
  const auto positive = [](double value, const char* name) {
    require(std::isfinite(value) && value > 0.0,
            std::string("distance field: ") + name + " must be positive and finite, got " + std::to_string(value));
  };
  positive(options.spacing, "spacing");
  positive(options.band, "band");
  require(options.band >= least_band * options.spacing, "distance field: band " + std::to_string(options.band) +
                                                            " m must be at least 4 spacings of " +
                                                            std::to_string(options.spacing) + " m");
  require(options.low.allFinite() && options.high.allFinite() && (options.low.array() < options.high.array()).all(),
          "distance field: the box needs finite corners, low below high in every coordinate");
  require(options.threads >= 1, "distance field: threads must be at least 1, got " + std::to_string(options.threads));
}

/// phi clipped to [-band, band]: unchanged up to band - width, constant from band + width, twice differentiable.
double clipped(double phi, double band, double width) {
  const double size = std::abs(phi);
  if (size <= band - width) return phi;
  if (size >= band + width) return std::copysign(band, phi);
  const double t = (size - (band - width)) / (2.0 * width);
  return std::copysign(size - 2.0 * width * t * t * t * (1.0 - 0.5 * t), phi);
}

/// The box of interest with a rim of lattice points for the spline; of a closed wall only the part near it. Points are
/// at multiples of the spacing, so that fields of mirrored walls are mirrored.
Lattice lattice_over(const NearestFeature& wall, const DistanceFieldOptions& options, double reach) {
  const double h = options.spacing;
  Box box;
  box.add(options.low);
  box.add(options.high);
  if (wall.ends().empty()) {
    Box near;
    for (const Vector3& v : wall.topology().vertices) near.add(v);
    const Vector3 margin = Vector3::Constant(reach + h);
    box.low = box.low.cwiseMax(near.low - margin).cwiseMin(box.high);
    box.high = box.high.cwiseMin(near.high + margin).cwiseMax(box.low);
  }
  Lattice lattice;
  lattice.spacing = h;
  double points = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double first = std::floor(box.low[axis] / h) - 2.0, last = std::ceil(box.high[axis] / h) + 3.0;
    points *= last - first + 1.0;
    require(points <= most_points,
            "distance field: the box at this spacing has more than 4e7 lattice points; take a larger spacing");
    lattice.origin[axis] = first * h;
    lattice.size[static_cast<std::size_t>(axis)] = static_cast<int>(last - first) + 1;
  }
  return lattice;
}

double surface_error(const NearestFeature& wall, const SplineGrid& spline) {
  std::vector<double> errors;
  const auto measure = [&](const Vector3& x) {
    if (spline.covers(x)) errors.push_back(std::abs(spline.value(x)));
  };
  const WallTopology& topology = wall.topology();
  for (std::size_t v = 0; v < topology.vertices.size(); ++v)
    if (topology.vertex_kinds[v] == FeatureKind::interior) measure(topology.vertices[v]);
  for (const TriangleShape& shape : wall.shapes()) measure(shape.a + (shape.ab + shape.ac) / 3.0);
  if (errors.empty()) return 0.0;
  const auto rank = static_cast<std::ptrdiff_t>(error_percentile * static_cast<double>(errors.size() - 1));
  std::nth_element(errors.begin(), errors.begin() + rank, errors.end());
  return errors[static_cast<std::size_t>(rank)];
}

/// Where the spline is not defined.
double beyond(const Vector3& x, double band) {
  return x.hasNaN() ? std::numeric_limits<double>::quiet_NaN() : band;
}

}  // namespace

DistanceField::DistanceField(const WallSurface& surface, const DistanceFieldOptions& options) : band_(options.band) {
  check(options);
  const NearestFeature wall(surface);
  const double width = clip_width * options.spacing;
  const Lattice lattice = lattice_over(wall, options, band_ + width);
  DistanceSamples samples = wall_distance(wall, lattice, band_ + width, options.threads);
  for (double& phi : samples.distance) phi = clipped(phi, band_, width);
  spline_ = SplineGrid(lattice, std::move(samples.distance), options.threads);
  geometric_error_ = surface_error(wall, spline_);
}

double DistanceField::distance(const Vector3& x) const {
  return spline_.covers(x) ? spline_.value(x) : beyond(x, band_);
}

double DistanceField::value(const Vector3& x, Vector3& gradient) const {
  if (spline_.covers(x)) return spline_.value(x, gradient);
  gradient.setZero();
  return beyond(x, band_);
}

double DistanceField::value(const Vector3& x, Vector3& gradient, Matrix3& hessian) const {
  if (spline_.covers(x)) return spline_.value(x, gradient, hessian);
  gradient.setZero();
  hessian.setZero();
  return beyond(x, band_);
}

}  // namespace glossa
