#include "scene/equilibrium.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "solver/anderson.hpp"

namespace glossa {
namespace {

// Residual that rounding leaves at rest, where no force sets a scale: relative to bulk modulus times area of the body.
constexpr double rounding = 1e-14;

class EquilibriumSolver {
 public:
  EquilibriumSolver(System& system, const EquilibriumOptions& options, Report& report)
      : system_(system), options_(options), report_(report), trial_(system.rest_trial()) {
    const double extent = system.scene().mesh().extent();
    max_step_ = options.max_step * extent;
    least_force_ = rounding * system.scene().options().tissue.kappa * extent * extent;
  }

  bool start(const NodeField& positions, const std::vector<double>& pressure) {
    trial_.positions = positions;
    evaluate(trial_, true);
    if (pressure.empty())
      system_.elasticity().set_pressure(trial_.pressure);
    else
      std::copy(pressure.begin(), pressure.end(), trial_.pressure.begin());
    return uninverted();
  }

  Status reach(const NodeField& target) {
    NodeField gap(target.size());
    double left = 1.0;
    while (left > 0.0) {
      bool moved = false;
      for (std::size_t k = 0; k < gap.size(); ++k) {
        gap[k] = system_.free()[k] ? 0.0 : target[k] - trial_.positions[k];
        moved = moved || gap[k] != 0.0;
      }
      if (!moved) break;
      const Status status = advance(gap, left);
      if (status != Status::converged) return status;
      if (left > 0.0) {
        const Status loose = minimise(1e-2);
        if (loose != Status::converged) return loose;
      }
    }
    return Status::converged;
  }

  Status minimise(double tolerance) {
    Status status = iterate(tolerance, false);
    if (status == Status::iteration_limit || status == Status::stalled) status = iterate(tolerance, true);
    return status;
  }

  [[nodiscard]] const Trial& trial() const { return trial_; }
  [[nodiscard]] const NodeField& force() const { return force_; }

 private:
  [[nodiscard]] bool uninverted() { return system_.elasticity().least_jacobian() > 0.0; }

  // Forces at the trial; with `follow` the stiffening factors are those of its activations.
  void evaluate(Trial& trial, bool follow) {
    ++report_.residuals;
    system_.measure(trial);
    if (follow) system_.stiffening(trial, trial.isochoric_scale);
    system_.force(trial, force_);
    residual_ = system_.norm_free(force_);
    scale_ = system_.force_scale();
  }

  [[nodiscard]] bool small(double tolerance) const { return residual_ <= tolerance * scale_ + least_force_; }

  // Moves the held components by as much of `gap` as a linear predictor can be trusted with: no point further than two
  // Newton steps (a long jump may end in another, crushed equilibrium), no element inverted.
  Status advance(const NodeField& gap, double& left) {
    system_.assemble(trial_, 0.0, report_);
    NodeField coupling;
    system_.multiply(trial_, gap, coupling);
    if (!system_.factorise(report_)) return Status::indefinite;
    const Vector residual = system_.restrict_free(force_), stiffness = system_.restrict_free(coupling);
    double farthest = 0.0;
    for (const double x : gap) farthest = std::max(farthest, std::abs(x));
    for (double part = std::min(1.0, 2.0 * max_step_ / farthest); part > 1e-6; part *= 0.5) {
      Vector step = residual + part * stiffness;
      system_.newton_step(step);
      Trial next = trial_;
      NodeField increment(gap.size(), 0.0);
      system_.add_free(step, 1.0, increment);
      for (std::size_t k = 0; k < gap.size(); ++k) increment[k] += part * gap[k];
      for (std::size_t k = 0; k < gap.size(); ++k) next.positions[k] += increment[k];
      if (part == 1.0)
        for (std::size_t k = 0; k < gap.size(); ++k)
          if (!system_.free()[k]) next.positions[k] = trial_.positions[k] + gap[k];
      evaluate(next, true);
      if (std::isfinite(residual_) && uninverted() && largest(step) < 4.0 * max_step_) {
        trial_ = std::move(next);
        system_.elasticity().set_pressure(trial_.pressure);
        left = part == 1.0 ? 0.0 : 1.0;
        return Status::converged;
      }
      ++report_.line_search;
    }
    evaluate(trial_, true);
    return Status::inverted;
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
      system_.assemble(trial_, 0.0, report_);
      if (!system_.factorise(report_)) return Status::indefinite;
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
    NodeField increment(trial_.positions.size(), 0.0);
    system_.add_free(step, 1.0, increment);
    std::vector<double> predicted = trial_.pressure;
    system_.elasticity().predict_pressure(increment, 1.0, predicted);
    const double before = residual_;
    bool met_inversion = false;
    for (int cut = 0; cut < 30; ++cut, length *= 0.5) {
      Trial next = trial_;
      system_.add_free(step, length, next.positions);
      evaluate(next, false);
      const bool valid = std::isfinite(residual_) && uninverted();
      met_inversion = met_inversion || !valid;
      const double change = valid ? system_.energy(next) - energy : 0.0;
      const double noise = 1e-13 * (std::abs(energy) + 1e-6);
      if (valid && (change <= 1e-4 * length * slope + noise || (length == 1.0 && residual_ < 0.1 * before))) {
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
    return met_inversion ? Status::inverted : Status::stalled;
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
      NodeField increment(trial_.positions.size(), 0.0);
      system_.add_free(step, length, increment);
      system_.elasticity().predict_pressure(increment, 1.0, trial_.pressure);
      system_.add_free(step, length, trial_.positions);
      evaluate(trial_, true);
      if (!std::isfinite(residual_) || !uninverted() || residual_ > 3.0 * best_residual) break;
      if (residual_ < best_residual) {
        best = trial_;
        best_residual = residual_;
      }
      if (k % 4 == 0) {
        if (best_residual > 0.2 * milestone) break;
        milestone = best_residual;
      }
    }
    if (small(tolerance) && uninverted()) return Status::converged;
    trial_ = std::move(best);
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

 public:
  [[nodiscard]] double residual() const { return residual_; }
  [[nodiscard]] double scale() const { return scale_; }
};

}  // namespace

Equilibrium equilibrate(System& system, const NodeField& start, const std::vector<double>& pressure,
                        const NodeField& target, const EquilibriumOptions& options) {
  require_supported(system.scene().mesh(), system.free());
  const HexMesh& mesh = system.scene().mesh();
  require(start.size() == mesh.nodes().size() && target.size() == mesh.nodes().size() &&
              (pressure.empty() || pressure.size() == static_cast<std::size_t>(mesh.element_count())),
          "equilibrium: start, target and pressures must fit the body");
  const auto begin = std::chrono::steady_clock::now();
  system.seconds() = Seconds{};
  Equilibrium result;
  Report& report = result.report;
  EquilibriumSolver solver(system, options, report);
  if (!solver.start(start, pressure))
    report.status = Status::inverted;
  else {
    report.status = solver.reach(target);
    if (report.status == Status::converged) report.status = solver.minimise(options.tolerance);
  }
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
  report.seconds = system.seconds();
  report.seconds.total = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

}  // namespace glossa
