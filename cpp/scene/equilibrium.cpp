#include "scene/equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "solver/anderson.hpp"

namespace glossa {
namespace {

// Residual that rounding leaves at rest, where no force sets a scale: relative to bulk modulus times area of the body.
constexpr double rounding = 1e-14;
// Residual over force scale while the multipliers of contact still change.
constexpr double loose_tolerance = 1e-4;
constexpr int undamped_updates = 5;  // of the friction bounds, before they are damped, the more the longer they cycle
constexpr int cautious_tangents = 2;
constexpr double friction_tolerance = 0.01;  // error of the friction bounds over the sum of pressures
// Residuals over force scale below which friction bounds follow the pressures, and the curvature of walls is trusted.
constexpr double bounds_follow = 0.03;
constexpr int following_tangents = 8;  // after which they are held and join the multipliers
constexpr double curvature_counts = 0.01;
constexpr double wall_step = 1.5e-3;  // m, farthest move of a wall between two solves

class EquilibriumSolver {
 public:
  EquilibriumSolver(System& system, const EquilibriumOptions& options, Report& report)
      : system_(system), options_(options), report_(report), trial_(system.rest_trial()) {
    const double extent = system.scene().mesh().extent();
    max_step_ = options.max_step * extent;
    least_force_ = rounding * system.scene().options().tissue.kappa * extent * extent;
    wall_shift_ = options.wall_start;
  }
  // Movements use the same effects, with bounds that are held within a step.
  ~EquilibriumSolver() {
    if (WallContact* contact = system_.contact()) contact->follow_bounds(false);
  }
  EquilibriumSolver(const EquilibriumSolver&) = delete;
  EquilibriumSolver& operator=(const EquilibriumSolver&) = delete;

  Status start(const NodeField& positions, const std::vector<double>& pressure) {
    trial_.positions = positions;
    system_.place_tied(trial_.positions);
    if (WallContact* contact = system_.contact()) {
      contact->clear();
      const std::vector<Vector3> at_rest(wall_shift_.size(), Vector3::Zero());
      contact->begin_increment(system_.scene().mesh().nodes(), at_rest);
      contact->set_shift(wall_shift_);
      if (!options_.contact_start.empty()) contact->resume(trial_.positions, options_.contact_start);
    }
    evaluate(trial_, true);
    if (pressure.empty())
      system_.elasticity().set_pressure(trial_.pressure);
    else
      std::copy(pressure.begin(), pressure.end(), trial_.pressure.begin());
    return state_of_trial();
  }

  Status reach(const NodeField& target) {
    NodeField gap(target.size());
    double left = 1.0;
    for (bool first = true; left > 0.0; first = false) {
      bool moved = false;
      for (std::size_t k = 0; k < gap.size(); ++k) {
        gap[k] = system_.moving()[k] ? 0.0 : target[k] - trial_.positions[k];
        moved = moved || gap[k] != 0.0;
      }
      if (!moved && wall_shift_ == options_.wall_shift) break;
      // With contact from the start: what is far from equilibrium would move further than a displaced wall or node may.
      if (!first || system_.contact() != nullptr) {
        const Status loose = minimise(1e-2);
        if (loose != Status::converged) return loose;
      }
      const Status status = advance(gap, left);
      if (status != Status::converged) return status;
    }
    return Status::converged;
  }

  Status solve() {
    if (system_.contact() == nullptr) return minimise(options_.tolerance);
    bounds_may_follow_ = true;
    const Status status = settle(options_.tolerance);
    const bool may_help = status == Status::iteration_limit || status == Status::stalled;
    if (!may_help || system_.scene().contact_law().friction == 0.0) return status;
    bounds_may_follow_ = false;
    return settle(loose_tolerance);
  }

  // Solves and updates multipliers in turn. While they still change, the residual need not be small.
  Status settle(double tolerance) {
    WallContact* contact = system_.contact();
    tolerance = std::max(options_.tolerance, tolerance);
    Status status = minimise(tolerance);
    for (int update = 0; status == Status::converged; ++update) {
      const bool settled = contact->bound_error() <= friction_tolerance;
      if (settled && contact->violation() <= options_.gap_tolerance) {
        if (tolerance == options_.tolerance) {
          if (contact->bound_error() > 0.0) free_bounds();
          return status;
        }
        tolerance = options_.tolerance;
      } else if (update >= options_.max_contact_updates)
        return Status::iteration_limit;
      else {
        ++report_.contact_updates;
        contact->update(options_.gap_tolerance);
        contact->update_bounds(update < undamped_updates ? 1.0 : std::min(0.5, 2.0 * undamped_updates / update));
        tolerance = std::max(options_.tolerance, loose_tolerance);
      }
      status = resume(tolerance);
    }
    return status;
  }

  // Where held bounds have led to the solution, they may follow the last micrometres after all; else all stays as it
  // is.
  void free_bounds() {
    WallContact& contact = *system_.contact();
    const Trial kept = trial_;
    ContactState state = contact.state();
    bounds_may_follow_ = true;
    evaluate(trial_, true);
    if (options_.quasi_newton && factor_stamp_ == system_.factor_stamp() &&
        quasi_newton(options_.tolerance) == Status::converged && contact.violation() <= options_.gap_tolerance)
      return;
    bounds_may_follow_ = false;
    trial_ = kept;
    contact.set_state(std::move(state));
    evaluate(trial_, true);
  }

  // On from the present state, at first with the present factor.
  Status resume(double tolerance) {
    evaluate(trial_, true);
    if (small(tolerance)) return Status::converged;
    if (options_.quasi_newton && factor_stamp_ == system_.factor_stamp()) {
      const Status status = quasi_newton(tolerance);
      if (status == Status::converged || status == Status::interrupted) return status;
    }
    return minimise(tolerance);
  }

  Status minimise(double tolerance) {
    Status status = iterate(tolerance, false);
    if (status == Status::iteration_limit || status == Status::stalled) status = iterate(tolerance, true);
    return status;
  }

  [[nodiscard]] const Trial& trial() const { return trial_; }
  [[nodiscard]] const NodeField& force() const { return force_; }

 private:
  // Whether a solve can go on from the last trial: converged, inverted or penetrated.
  [[nodiscard]] Status state_of_trial() {
    if (!std::isfinite(residual_) || !(system_.elasticity().least_jacobian() > 0.0)) return Status::inverted;
    return system_.lost() ? Status::penetrated : Status::converged;
  }
  [[nodiscard]] bool valid() { return state_of_trial() == Status::converged; }

  [[nodiscard]] bool renew_factor() {
    const int before = report_.indefinite;
    const bool done = system_.renew_factor(trial_, 0.0, report_, cautious_ == 0 && near(curvature_counts));
    cautious_ = report_.indefinite > before ? cautious_tangents : std::max(0, cautious_ - 1);
    factor_stamp_ = system_.factor_stamp();
    return done;
  }

  // Forces at the trial; with `follow` the stiffening factors are those of its activations and, near the solution, the
  // friction bounds those of its pressures.
  void evaluate(Trial& trial, bool follow) {
    ++report_.residuals;
    if (WallContact* contact = system_.contact()) {
      const bool bounds_too = follow && bounds_may_follow_ && near(bounds_follow);
      contact->follow_bounds(bounds_too);
      followed_ = followed_ || bounds_too;
    }
    system_.measure(trial);
    if (follow) system_.stiffening(trial, trial.isochoric_scale);
    system_.force(trial, force_);
    system_.reduce(trial, force_);
    residual_ = system_.norm_free(force_);
    scale_ = system_.force_scale();
  }

  [[nodiscard]] bool near(double share) const { return residual_ < share * scale_; }
  [[nodiscard]] bool small(double tolerance) const { return residual_ <= tolerance * scale_ + least_force_; }

  // Moves held components and walls by as much of what is left as a linear predictor can be trusted with: no point
  // further than two Newton steps (a long jump may end in another, crushed equilibrium), no wall further than points
  // find back from behind it, no element inverted.
  Status advance(const NodeField& gap, double& left) {
    if (!renew_factor()) return Status::indefinite;
    NodeField coupling(gap.size(), 0.0);
    system_.multiply(trial_, gap, coupling);
    const Vector residual = system_.restrict_free(force_), stiffness = system_.restrict_free(coupling);
    double farthest = 0.0, farthest_wall = 0.0;
    for (const double x : gap) farthest = std::max(farthest, std::abs(x));
    const std::vector<Vector3> shift = wall_shift_;
    for (std::size_t w = 0; w < shift.size(); ++w)
      farthest_wall = std::max(farthest_wall, (options_.wall_shift[w] - shift[w]).norm());
    const double longest = std::min({1.0, 2.0 * max_step_ / farthest, wall_step / farthest_wall});
    Status refused = Status::inverted;
    for (double part = longest; part > 1e-6; part *= 0.5) {
      Vector step = residual + part * stiffness;
      system_.newton_step(step);
      Trial next = trial_;
      const NodeField increment = system_.spread(step, 1.0, trial_.positions);
      system_.move(step, 1.0, next.positions);
      for (std::size_t k = 0; k < gap.size(); ++k) next.positions[k] += part * gap[k];
      if (part == 1.0)
        for (std::size_t k = 0; k < gap.size(); ++k)
          if (!system_.moving()[k]) next.positions[k] = trial_.positions[k] + gap[k];
      move_walls(shift, part);
      evaluate(next, true);
      refused = state_of_trial();
      if (refused == Status::converged && largest(step) < 4.0 * max_step_) {
        trial_ = std::move(next);
        system_.elasticity().set_pressure(trial_.pressure);
        left = part == 1.0 ? 0.0 : 1.0;
        return Status::converged;
      }
      ++report_.line_search;
    }
    move_walls(shift, 0.0);
    evaluate(trial_, true);
    return refused == Status::converged ? Status::inverted : refused;
  }

  void move_walls(const std::vector<Vector3>& from, double part) {
    for (std::size_t w = 0; w < from.size(); ++w)
      wall_shift_[w] =
          part == 1.0 ? options_.wall_shift[w] : Vector3(from[w] + part * (options_.wall_shift[w] - from[w]));
    if (system_.contact() != nullptr) system_.contact()->set_shift(wall_shift_);
  }

  static double largest(const Vector& step) { return step.size() > 0 ? step.cwiseAbs().maxCoeff() : 0.0; }

  Status iterate(double tolerance, bool hold_factors) {
    evaluate(trial_, true);
    double outer_target = 0.0;  // residual at which held factors are updated
    for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
      report_.residuals_by_iteration.push_back(residual_);
      if (options_.interrupt && options_.interrupt()) return Status::interrupted;
      if (small(tolerance)) return Status::converged;
      if (hold_factors && outer_target == 0.0) outer_target = 0.03 * residual_;
      ++report_.iterations;
      if (std::exchange(followed_, false) && ++following_ > following_tangents) bounds_may_follow_ = false;
      if (!renew_factor()) return Status::indefinite;
      const double before = residual_;
      double step = 0.0;
      const Status status = newton_step(hold_factors, step);
      if (status != Status::converged) return status;
      if (hold_factors && residual_ > outer_target) continue;
      if (hold_factors) {
        evaluate(trial_, true);
        outer_target = 0.0;
      }
      if (options_.quasi_newton && step == 1.0 && residual_ < 0.5 * before) {
        const Status finished = quasi_newton(tolerance);
        if (finished == Status::interrupted || finished == Status::converged) return finished;
      }
    }
    return Status::iteration_limit;
  }

  // One Newton step on the energy with the stiffening factors held, then the factors follow unless held further.
  Status newton_step(bool hold_factors, double& accepted) {
    const Vector G = system_.restrict_free(force_);
    Vector step = G;
    system_.newton_step(step);
    const double reach = largest(step);
    double length = reach > max_step_ ? max_step_ / reach : 1.0;
    const double slope = G.dot(step);
    const double energy = system_.energy(trial_);
    const NodeField increment = system_.spread(step, 1.0, trial_.positions);
    std::vector<double> predicted = trial_.pressure;
    system_.elasticity().predict_pressure(increment, 1.0, predicted);
    const double before = residual_;
    Status refused = Status::stalled;
    for (int cut = 0; cut < 30; ++cut, length *= 0.5) {
      Trial next = trial_;
      system_.move(step, length, next.positions);
      evaluate(next, false);
      const Status status = state_of_trial();
      if (status != Status::converged) refused = status;
      const double change = status == Status::converged ? system_.energy(next) - energy : 0.0;
      const double noise = 1e-13 * (std::abs(energy) + 1e-6);
      if (status == Status::converged &&
          (change <= 1e-4 * length * slope + noise || (length == 1.0 && residual_ < 0.1 * before))) {
        for (std::size_t e = 0; e < predicted.size(); ++e)
          next.pressure[e] += length * (predicted[e] - next.pressure[e]);
        trial_ = std::move(next);
        if (!hold_factors) refresh();
        accepted = length;
        return Status::converged;
      }
      ++report_.line_search;
    }
    evaluate(trial_, false);
    return refused;
  }

  // Lets the stiffening factors follow the activations of the present trial.
  void refresh() { evaluate(trial_, true); }

  // Anderson iteration with the present factor; keeps the best iterate. Ends converged, interrupted or, when it is no
  // longer worth its price, stalled.
  Status quasi_newton(double tolerance) {
    anderson_.reset();
    Trial best = trial_;
    double best_residual = residual_, milestone = residual_;
    for (int k = 1; k <= 40 && !small(tolerance); ++k) {
      if (options_.interrupt && options_.interrupt()) return Status::interrupted;
      ++report_.quasi_newton;
      const Vector G = system_.restrict_free(force_);
      Vector F = G;
      system_.precondition(F);
      const Vector u = system_.restrict_free(trial_.positions);
      Vector step = anderson_.increment(u, F, G);
      const double reach = largest(step);
      const double length = reach > max_step_ ? max_step_ / reach : 1.0;
      system_.elasticity().predict_pressure(system_.spread(step, length, trial_.positions), 1.0, trial_.pressure);
      system_.move(step, length, trial_.positions);
      evaluate(trial_, true);
      if (!valid() || residual_ > 3.0 * best_residual) break;
      if (residual_ < best_residual) {
        best = trial_;
        best_residual = residual_;
      }
      if (k % 4 == 0) {
        if (best_residual > 0.2 * milestone) break;
        milestone = best_residual;
      }
    }
    if (small(tolerance) && valid()) return Status::converged;
    trial_ = std::move(best);
    residual_ = best_residual;
    evaluate(trial_, true);
    return Status::stalled;
  }

  System& system_;
  const EquilibriumOptions& options_;
  Report& report_;
  Trial trial_;
  NodeField force_;
  Anderson anderson_;
  double residual_ = 0.0;
  double scale_ = 0.0;
  double least_force_ = 0.0;
  double max_step_ = 0.0;  // m
  bool bounds_may_follow_ = false;
  bool followed_ = false;   // they have, since the last Newton iteration
  int following_ = 0;       // Newton iterations after which they had
  int cautious_ = 0;        // tangents to come without negative curvature of walls, since one was indefinite with it
  long factor_stamp_ = -1;  // of the system's factor when this solve made it
  std::vector<Vector3> wall_shift_;

 public:
  [[nodiscard]] double residual() const { return residual_; }
  [[nodiscard]] double scale() const { return scale_; }
};

}  // namespace

Equilibrium equilibrate(System& system, const NodeField& start, const std::vector<double>& pressure,
                        const NodeField& target, const EquilibriumOptions& options) {
  require_supported(system.scene().mesh(), system.moving());
  const HexMesh& mesh = system.scene().mesh();
  require(start.size() == mesh.nodes().size() && target.size() == mesh.nodes().size() &&
              (pressure.empty() || pressure.size() == static_cast<std::size_t>(mesh.element_count())),
          "equilibrium: start, target and pressures must fit the body");
  const auto& contact = system.scene().options().contact;
  const std::size_t walls = contact ? contact->walls.size() : 0;
  require(options.wall_start.size() == walls && options.wall_shift.size() == walls,
          "equilibrium: one displacement per wall is needed");
  require(options.contact_start.empty() ||
              options.contact_start.size() == (contact ? static_cast<std::size_t>(contact->points.count()) : 0),
          "equilibrium: one contact pressure per contact point is needed");
  const auto begin = std::chrono::steady_clock::now();
  system.seconds() = Seconds{};
  Equilibrium result;
  Report& report = result.report;
  EquilibriumSolver solver(system, options, report);
  report.status = solver.start(start, pressure);
  if (report.status == Status::converged) report.status = solver.reach(target);
  if (report.status == Status::converged) report.status = solver.solve();
  const Trial& trial = solver.trial();
  report.residual = solver.residual();
  report.force_scale = solver.scale();
  report.least_jacobian = system.elasticity().least_jacobian();
  report.worst_element = system.elasticity().worst_element();
  const auto elements = static_cast<std::ptrdiff_t>(system.scene().mesh().element_count());
  result.positions = trial.positions;
  result.pressure.assign(trial.pressure.begin(), trial.pressure.begin() + elements);
  result.stiffening.assign(trial.isochoric_scale.begin(), trial.isochoric_scale.begin() + elements);
  result.force = solver.force();
  const auto fibres = static_cast<std::size_t>(system.scene().options().fibres.count());
  result.activation.assign(fibres, 0.0);
  result.tension.assign(fibres, 0.0);
  for (std::size_t k = 0; k < system.fibre_of().size(); ++k) {
    result.activation[static_cast<std::size_t>(system.fibre_of()[k])] = trial.activation[k];
    result.tension[static_cast<std::size_t>(system.fibre_of()[k])] = system.muscles()->tensions()[k];
  }
  if (const WallContact* touching = system.contact()) {
    report.penetration = touching->penetration();
    report.contact_violation = touching->violation();
    touching->tractions(result.contact_pressure, result.contact_drag);
  }
  report.seconds = system.seconds();
  report.seconds.total = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

}  // namespace glossa
