#include "effect/wall_contact.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Eigenvalues>

#include "core/parallel.hpp"

namespace glossa {
namespace {

constexpr double lipschitz = 1.4;       // a smoothed distance may grow a little faster than the way
constexpr double survey_again = 4e-4;   // m, move after which clearances are measured afresh
constexpr double known_depth = 0.95;    // of the band of a distance field
constexpr double least_advance = 1e-9;  // m, less is rounding
constexpr int points_for_a_thread = 32;

}  // namespace

WallContact::WallContact(const ContactPoints& points, const Walls& walls, const ContactLaw& law, int threads)
    : points_(points),
      walls_(walls),
      law_(law),
      threads_(threads),
      shift_(walls.size(), Vector3::Zero()),
      cells_(static_cast<std::size_t>(points.count())) {
  std::map<std::vector<Index>, Index> known;
  for (Index k = 0; k < points.count(); ++k) {
    std::vector<Index> nodes;
    double reach = 0.0;
    for (const PointWeight* w = points.weights.begin(k); w != points.weights.end(k); ++w) {
      nodes.push_back(w->node);
      reach += std::max(std::abs(w->along), std::abs(w->across));
    }
    reach_.push_back(lipschitz * reach);
    nodes_.insert(nodes_.end(), nodes.begin(), nodes.end());
    const auto [it, fresh] = known.try_emplace(std::move(nodes), groups_.size());
    if (fresh) {
      groups_.values.insert(groups_.values.end(), it->first.begin(), it->first.end());
      groups_.push_row();
    }
    group_.push_back(it->second);
  }
  std::sort(nodes_.begin(), nodes_.end());
  nodes_.erase(std::unique(nodes_.begin(), nodes_.end()), nodes_.end());
  clear();
}

void WallContact::clear() {
  const auto count = static_cast<std::size_t>(points_.count());
  state_.advance.assign(count, 0.0);
  state_.pressure.assign(law_.friction > 0.0 ? count : 0, 0.0);
  state_.friction.assign(state_.pressure.size(), Vector3::Zero());
  state_.normal = state_.friction;
  state_.slip_from = state_.friction;
}

void WallContact::set_state(ContactState state) {
  state_ = std::move(state);
}

void WallContact::bind(const BlockMatrix& matrix) {
  slot_start_.assign(1, 0);
  slots_.clear();
  for (Index g = 0; g < groups_.size(); ++g) {
    const Index* nodes = groups_.begin(g);
    for (Index b = 0; b < groups_.length(g); ++b)
      for (Index a = 0; a <= b; ++a) slots_.push_back(matrix.slot(nodes[a], nodes[b]));
    slot_start_.push_back(static_cast<Index>(slots_.size()));
  }
}

void WallContact::set_shift(const std::vector<Vector3>& shift) {
  if (shift == shift_) return;
  shift_ = shift;
  surveyed_at_.clear();
}

void WallContact::begin_increment(const NodeField& positions, const std::vector<Vector3>& shift) {
  if (law_.friction == 0.0) return;
  for (Index k = 0; k < points_.count(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    state_.slip_from[i] = points_.position(k, positions) - shift[static_cast<std::size_t>(points_.wall[i])];
  }
}

double WallContact::farthest_move(const NodeField& positions) const {
  double farthest = 0.0;
  for (const Index n : nodes_) farthest = std::max(farthest, (at(positions, n) - at(surveyed_at_, n)).squaredNorm());
  return std::sqrt(farthest);
}

void WallContact::survey(const NodeField& positions) {
  surveyed_at_ = positions;
  clearance_.resize(static_cast<std::size_t>(points_.count()));
  const auto look = [&](int begin, int end) {
    for (Index k = begin; k < end; ++k) {
      const auto i = static_cast<std::size_t>(k), wall = static_cast<std::size_t>(points_.wall[i]);
      clearance_[i] = walls_[wall]->distance(points_.position(k, positions) - shift_[wall]) + points_.offset[i];
    }
  };
  parallel_ranges(points_.count(), threads_, look, points_for_a_thread);
}

void WallContact::add_force(const Trial& trial, NodeField& force) {
  active_.clear();
  lost_ = false;
  const bool finite =
      std::all_of(nodes_.begin(), nodes_.end(), [&](Index n) { return at(trial.positions, n).allFinite(); });
  if (!finite) {
    lost_ = true;
    return;
  }
  double moved = surveyed_at_.empty() ? survey_again : farthest_move(trial.positions);
  if (moved >= survey_again) {
    survey(trial.positions);
    moved = 0.0;
  }
  near_.clear();
  for (Index k = 0; k < points_.count(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    const bool bound = !state_.pressure.empty() && state_.pressure[i] != 0.0;
    if (bound || state_.advance[i] != 0.0 || clearance_[i] <= reach_[i] * moved) near_.push_back({.point = k});
  }
  measure(trial.positions);
  for (Active& point : near_) {
    const auto i = static_cast<std::size_t>(point.point);
    const auto wall = static_cast<std::size_t>(points_.wall[i]);
    const double advance = state_.advance[i];
    double bound = state_.pressure.empty() ? 0.0 : law_.friction * state_.pressure[i];
    lost_ = lost_ || point.gap < -known_depth * walls_[wall]->band();
    point.gap += points_.offset[i];
    point.depth = advance - point.gap;
    point.pressure = law_.pressure(point.depth);
    if (follow_bounds_ && law_.friction > 0.0) {
      bind_friction(i, point.pressure, point.gradient);
      bound = law_.friction * point.pressure;
    }
    point.bound = bound;
    if (point.pressure == 0.0 && advance == 0.0 && bound == 0.0) continue;
    Vector3 push = -point.pressure * point.gradient;
    if (point.bound > 0.0) {
      point.trial = law_.trial_traction(state_.friction[i],
                                        tangential(i) * (point.position - shift_[wall] - state_.slip_from[i]));
      push += ContactLaw::bounded(point.trial, point.bound);
    }
    push *= points_.area[i];
    for (const PointWeight* w = points_.weights.begin(point.point); w != points_.weights.end(point.point); ++w)
      Eigen::Map<Vector3>(force.data() + 3 * w->node) += w->diagonal().cwiseProduct(push);
    active_.push_back(point);
  }
}

void WallContact::measure(const NodeField& positions) {
  const auto look = [&](int begin, int end) {
    for (auto n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end); ++n) {
      Active& point = near_[n];
      const auto i = static_cast<std::size_t>(point.point), wall = static_cast<std::size_t>(points_.wall[i]);
      point.position = points_.position(point.point, positions);
      point.gap = walls_[wall]->value(point.position - shift_[wall], point.gradient, cells_[i]);
    }
  };
  parallel_ranges(static_cast<int>(near_.size()), threads_, look, points_for_a_thread);
}

Matrix3 WallContact::stiffness(const Active& active) const {
  const auto i = static_cast<std::size_t>(active.point);
  Matrix3 result = Matrix3::Zero();
  if (active.pressure > 0.0) {
    const auto wall = static_cast<std::size_t>(points_.wall[i]);
    Vector3 gradient;
    Matrix3 curvature;
    walls_[wall]->value(active.position - shift_[wall], gradient, curvature);
    curvature *= -active.pressure;
    if (drop_negative_) {
      const Eigen::SelfAdjointEigenSolver<Matrix3> eigen(curvature);
      curvature =
          eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
    }
    result = law_.slope(active.depth) * gradient * gradient.transpose() + curvature;
  }
  if (active.bound > 0.0) result += law_.friction_slope(active.trial, active.bound, tangential(i));
  return points_.area[i] * result;
}

void WallContact::add_tangent(const Trial&, BlockMatrix& matrix) {
  for (const Active& active : active_) {
    const Matrix3 K = stiffness(active);
    const PointWeight* weights = points_.weights.begin(active.point);
    const Index count = points_.weights.length(active.point);
    const BlockMatrix::Slot* slot =
        slots_.data() + slot_start_[static_cast<std::size_t>(group_[static_cast<std::size_t>(active.point)])];
    for (Index b = 0; b < count; ++b) {
      const Matrix3 right = K * weights[b].diagonal().asDiagonal();
      for (Index a = 0; a <= b; ++a, ++slot) matrix.add(*slot, weights[a].diagonal().asDiagonal() * right);
    }
  }
}

void WallContact::multiply(const Trial&, const NodeField& x, NodeField& product) const {
  for (const Active& active : active_) {
    const Vector3 push = stiffness(active) * points_.position(active.point, x);
    for (const PointWeight* w = points_.weights.begin(active.point); w != points_.weights.end(active.point); ++w)
      Eigen::Map<Vector3>(product.data() + 3 * w->node) += w->diagonal().cwiseProduct(push);
  }
}

double WallContact::energy(const Trial&) const {
  double sum = 0.0;
  for (const Active& active : active_) {
    const auto i = static_cast<std::size_t>(active.point);
    double density = law_.energy(active.depth);
    if (active.bound > 0.0) density += law_.friction_energy(active.trial, active.bound);
    sum += points_.area[i] * density;
  }
  return sum;
}

double WallContact::violation() const {
  double worst = 0.0;
  for (const Active& active : active_) {
    const auto i = static_cast<std::size_t>(active.point);
    worst = std::max(worst, -active.gap);
    worst = std::max(worst, std::min(active.gap, state_.advance[i]));
  }
  return worst;
}

double WallContact::bound_error() const {
  if (law_.friction == 0.0) return 0.0;
  double wrong = 0.0, whole = 0.0;
  for (const Active& active : active_) {
    const auto i = static_cast<std::size_t>(active.point);
    wrong += points_.area[i] * std::abs(active.pressure - state_.pressure[i]);
    whole += points_.area[i] * active.pressure;
  }
  return whole > 0.0 ? wrong / whole : (wrong > 0.0 ? 1.0 : 0.0);
}

double WallContact::penetration() const {
  double deepest = 0.0;
  for (const Active& active : active_) deepest = std::max(deepest, -active.gap);
  return deepest;
}

Index WallContact::deepest() const {
  const auto it =
      std::min_element(active_.begin(), active_.end(), [](const Active& a, const Active& b) { return a.gap < b.gap; });
  return it == active_.end() ? -1 : it->point;
}

void WallContact::update(double gap_tolerance) {
  for (const Active& active : active_) {
    const auto i = static_cast<std::size_t>(active.point);
    if (active.gap < -gap_tolerance || (active.gap > 0.0 && state_.advance[i] > 0.0))
      state_.advance[i] = std::max(0.0, active.depth);
  }
}

void WallContact::update_bounds(double share) {
  if (law_.friction == 0.0) return;
  for (const Active& active : active_) {
    const auto i = static_cast<std::size_t>(active.point);
    bind_friction(i, state_.pressure[i] + share * (active.pressure - state_.pressure[i]), active.gradient);
  }
}

void WallContact::bind_friction(std::size_t k, double pressure, const Vector3& gradient) {
  const double length = gradient.norm();
  state_.pressure[k] = pressure;
  state_.normal[k] = length > 0.0 ? Vector3(gradient / length) : Vector3(Vector3::Zero());
}

void WallContact::resume(const NodeField& positions, const std::vector<double>& pressure) {
  for (Index k = 0; k < points_.count(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    if (!(pressure[i] > 0.0)) continue;
    const auto wall = static_cast<std::size_t>(points_.wall[i]);
    Vector3 gradient;
    const double gap = walls_[wall]->value(points_.position(k, positions) - shift_[wall], gradient) + points_.offset[i];
    const double advance = law_.depth(pressure[i]) + gap;
    if (advance > least_advance) state_.advance[i] = advance;
    if (law_.friction > 0.0) bind_friction(i, pressure[i], gradient);
  }
}

void WallContact::end_increment() {
  if (law_.friction == 0.0) return;
  std::fill(state_.friction.begin(), state_.friction.end(), Vector3::Zero());
  for (const Active& active : active_)
    if (active.bound > 0.0)
      state_.friction[static_cast<std::size_t>(active.point)] = ContactLaw::bounded(active.trial, active.bound);
  update_bounds(1.0);
  // What the next increment starts from lies in the new tangent plane.
  for (const Active& active : active_) {
    const auto i = static_cast<std::size_t>(active.point);
    state_.friction[i] = tangential(i) * state_.friction[i];
  }
}

void WallContact::tractions(std::vector<double>& pressure, std::vector<Vector3>& friction) const {
  pressure.assign(static_cast<std::size_t>(points_.count()), 0.0);
  friction.assign(pressure.size(), Vector3::Zero());
  for (const Active& active : active_) {
    const auto i = static_cast<std::size_t>(active.point);
    pressure[i] = active.pressure;
    if (active.bound > 0.0) friction[i] = ContactLaw::bounded(active.trial, active.bound);
  }
}

}  // namespace glossa
