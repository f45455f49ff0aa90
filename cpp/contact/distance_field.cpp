#include "contact/distance_field.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <utility>

#include "contact/wall_distance.hpp"
#include "core/error.hpp"

namespace glossa {
namespace {

constexpr double clip_width = 1.5;  // half width of the smooth clip, in spacings
constexpr double least_band = 4.0;  // in spacings: the clip must leave the surface alone
constexpr double most_points = 4e7;
constexpr double error_percentile = 0.95;
constexpr double area_of_point = 0.5e-6;  // m2, at most, of the surface for each point where it is looked at
constexpr double most_points_of_triangle = 2000.0;

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

/// Clips samples; bricks that are uniform then share a block.
void clip(DistanceSamples& samples, double band, double width) {
  for (double& phi : samples.distance.values) phi = clipped(phi, band, width);
  for (Index& block : samples.block_of) {
    const double* values = samples.distance.block(block);
    const bool uniform =
        std::all_of(values, values + LatticeBricks::volume, [&](double phi) { return phi == *values; });
    if (uniform && *values == band) block = DistanceSamples::free_block;
    if (uniform && *values == -band) block = DistanceSamples::behind_block;
  }
}

/// The box of interest with a rim of lattice points for the spline; of a closed wall only the part near it. Points are
/// at odd multiples of half the spacing and the first begins a brick counted from 0, so that bricks of mirrored walls
/// are mirrored and so are the fields.
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
    constexpr double edge = LatticeBricks::edge;
    const double first = edge * std::floor((std::floor(box.low[axis] / h) - 2.0) / edge);
    const double last = edge * std::ceil((std::ceil(box.high[axis] / h) + 2.0) / edge) - 1.0;
    points *= last - first + 1.0;
    require(points <= most_points,
            "distance field: the box at this spacing has more than 4e7 lattice points; take a larger spacing");
    lattice.origin[axis] = (first + 0.5) * h;
    lattice.size[static_cast<std::size_t>(axis)] = static_cast<int>(last - first) + 1;
  }
  return lattice;
}

/// Rims, and edges where the faces turn by more than 30 degrees or run different ways round: there the field is
/// rounded.
class SharpEdges {
 public:
  explicit SharpEdges(const WallTopology& wall) {
    std::vector<Box> boxes;
    for (const WallEdge& edge : wall.edges) {
      if (edge.kind == FeatureKind::interior && edge.normal.squaredNorm() > sharp) continue;
      const Vector3& a = wall.vertices[static_cast<std::size_t>(edge.a)];
      const Vector3& b = wall.vertices[static_cast<std::size_t>(edge.b)];
      edges_.push_back({a, b - a, (b - a).squaredNorm()});
      boxes.emplace_back();
      boxes.back().add(a);
      boxes.back().add(b);
    }
    tree_ = BoxTree(boxes);
  }
  [[nodiscard]] bool near(const Vector3& x) const {
    const auto measure = [&](Index e) { return edges_[static_cast<std::size_t>(e)].squared_distance(x); };
    return tree_.nearest(x, measure, reach * reach).item >= 0;
  }

 private:
  static constexpr double sharp = 2.0 + 2.0 * 0.866025403784438647;  // squared sum of unit normals 30 degrees apart
  static constexpr double reach = 2e-3;                              // m
  std::vector<SegmentShape> edges_;
  BoxTree tree_;
};

/// Percentile of values by weight.
double percentile(std::vector<std::pair<double, double>>& value_and_weight) {
  std::sort(value_and_weight.begin(), value_and_weight.end());
  double sum = 0.0;
  for (const auto& [value, weight] : value_and_weight) sum += weight;
  double left = error_percentile * sum;
  for (const auto& [value, weight] : value_and_weight) {
    left -= weight;
    if (left <= 0.0) return value;
  }
  return 0.0;
}

/// Points spread evenly over the unit triangle: v, w >= 0, v + w <= 1. An additive recurrence (Roberts 2018, "The
/// unreasonable effectiveness of quasirandom sequences").
class EvenPoints {
 public:
  std::pair<double, double> next() {
    constexpr double ratio = 1.32471795724474602596;  // root of x^3 = x + 1
    v_ = std::fmod(v_ + 1.0 / ratio, 1.0);
    w_ = std::fmod(w_ + 1.0 / (ratio * ratio), 1.0);
    return v_ + w_ <= 1.0 ? std::pair(v_, w_) : std::pair(1.0 - v_, 1.0 - w_);
  }

 private:
  double v_ = 0.5, w_ = 0.5;
};

/// |phi| over the wall where the spline covers it: away from sharp edges, and near them.
std::pair<double, double> surface_errors(const NearestFeature& wall, const SplineGrid& spline) {
  const SharpEdges sharp(wall.topology());
  std::vector<std::pair<double, double>> smooth, rounded;  // with the area a point stands for
  EvenPoints points;
  for (const TriangleShape& shape : wall.shapes()) {
    const double area = 0.5 * shape.ab.cross(shape.ac).norm();
    const int count = static_cast<int>(std::clamp(std::ceil(area / area_of_point), 1.0, most_points_of_triangle));
    for (int k = 0; k < count; ++k) {
      const auto [v, w] = points.next();
      const Vector3 x = shape.a + v * shape.ab + w * shape.ac;
      if (spline.covers(x)) (sharp.near(x) ? rounded : smooth).emplace_back(std::abs(spline.value(x)), area / count);
    }
  }
  return {percentile(smooth), percentile(rounded)};
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
  clip(samples, band_, width);
  spline_ = SplineGrid(samples.bricks, std::move(samples.block_of), samples.distance, options.threads);
  std::tie(geometric_error_, edge_rounding_) = surface_errors(wall, spline_);
}

double DistanceField::distance(const Vector3& x) const {
  return spline_.covers(x) ? spline_.value(x) : beyond(x, band_);
}

double DistanceField::value(const Vector3& x, Vector3& gradient) const {
  if (spline_.covers(x)) return spline_.value(x, gradient);
  gradient.setZero();
  return beyond(x, band_);
}

double DistanceField::value(const Vector3& x, Vector3& gradient, SplineCell& cell) const {
  if (spline_.covers(x)) return spline_.value(x, gradient, cell);
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
