// One step of a Simulation: its stages and the quasi-Newton iteration that solves them.
#include <algorithm>
#include <cmath>

#include "scene/simulation.hpp"

namespace glossa {
namespace {

constexpr int quasi_newton_limit = 24;
constexpr int slow_after = 16;  // iterations, with a factor of another state
constexpr int newton_limit = 20;
constexpr int worth_renewing = 9;       // iterations of a stage after which the factor is renewed
constexpr double worth_halving = 5e-4;  // s of a stage: rather than by Newton's method a longer one is solved in halves
constexpr int longest_search = 8;
constexpr double search_share = 0.5;  // of the slope at the start of a line search
constexpr double least_scale = 0.1;   // N, force to which the tolerance refers at least

}  // namespace

bool Simulation::attempt(double h, Integrator method, State& next, double& defect) {
  too_long_ = false;
  // The last step of a two-step method must not lie across a corner of the commands or one of its echoes.
  if (method == Integrator::bdf2 && (state_.last_step == 0.0 || h > 2.0 * state_.last_step || at_breakpoint()))
    method = Integrator::sdirk2;
  Stage stage = first_stage(h, method);
  if (WallContact* contact = system_.contact()) {
    enter_contact(state_.contact);
    contact->begin_increment(state_.positions, options_.wall_shift);
  }
  std::vector<double> end_activation;
  if (delayed() && system_.scene().options().damping.in_momentum() > 0.0) {
    given_activation(state_.time + h, false, end_activation);
    stage.rate = stiffening_of(end_activation);
    for (std::size_t e = 0; e < stage.rate.size(); ++e)
      stage.rate[e] = (stage.rate[e] - stage.base_stiffening[e]) / stage.span;
  }
  Trial trial = stage_trial(stage);
  if (!solve_stage(stage, trial)) return false;
  if (method == Integrator::sdirk2) {
    // u2 = u + (1 - gamma) h V1 + gamma h V2, and the same for w and, where the activation follows, for s.
    const double weight = (1.0 - sdirk2_gamma) / sdirk2_gamma;
    const NodeField momentum = stage_momentum(stage, trial);
    for (std::size_t k = 0; k < momentum.size(); ++k) {
      stage.base_positions[k] += weight * (trial.positions[k] - state_.positions[k]);
      stage.base_momentum[k] += weight * (momentum[k] - state_.momentum[k]);
    }
    std::vector<double> pressure = trial.pressure;
    system_.elasticity().set_pressure(pressure);
    for (std::size_t e = 0; e < pressure.size(); ++e)
      stage.base_pressure[e] += weight * (pressure[e] - state_.pressure[e]);
    stage.time = state_.time + h;
    stage.offset = h;
    if (!delayed()) {
      const std::vector<double> factors = stiffening_of(trial.activation);
      for (std::size_t e = 0; e < factors.size(); ++e)
        stage.base_stiffening[e] += weight * (factors[e] - state_.stiffening[e]);
    }
    NodeField guess = trial.velocities;
    for (std::size_t k = 0; k < guess.size(); ++k) guess[k] = stage.base_positions[k] + stage.hg * guess[k];
    trial = stage_trial(stage);
    for (std::size_t k = 0; k < guess.size(); ++k)
      if (system_.free()[k]) trial.positions[k] = guess[k];
    system_.place_tied(trial.positions);
    trial.pressure = std::move(pressure);
    if (!solve_stage(stage, trial)) return false;
  }
  finish(stage, trial, h, next);
  defect = 0.0;
  for (std::size_t k = 0; k < next.positions.size(); ++k)
    defect = std::max(defect, std::abs(next.positions[k] - state_.positions[k] -
                                       0.5 * h * (next.velocities[k] + state_.velocities[k])));
  return true;
}

Simulation::Stage Simulation::first_stage(double h, Integrator method) const {
  Stage stage;
  stage.base_positions = state_.positions;
  stage.base_momentum = state_.momentum;
  stage.base_stiffening = state_.stiffening;
  stage.base_pressure = state_.pressure;
  stage.hg = stage.offset = stage.span = h;
  if (method == Integrator::sdirk2) {
    stage.hg = stage.offset = sdirk2_gamma * h;
    if (!delayed()) stage.span = stage.hg;
  } else if (method == Integrator::trapezoidal) {
    stage.hg = 0.5 * h;
    for (std::size_t k = 0; k < stage.base_positions.size(); ++k) {
      stage.base_positions[k] += stage.hg * state_.velocities[k];
      stage.base_momentum[k] += stage.hg * state_.momentum_rate[k];
    }
    for (std::size_t e = 0; e < stage.base_pressure.size(); ++e)
      stage.base_pressure[e] += stage.hg * state_.pressure_rate[e];
  } else if (method == Integrator::bdf2) {
    const Bdf2 weights(h / state_.last_step);
    const auto mix = [&](auto& base, const auto& last) {
      for (std::size_t k = 0; k < base.size(); ++k) base[k] = weights.a * base[k] - weights.b * last[k];
    };
    stage.hg = stage.span = weights.c * h;
    mix(stage.base_positions, state_.last_positions);
    mix(stage.base_momentum, state_.last_momentum);
    mix(stage.base_stiffening, state_.last_stiffening);
    mix(stage.base_pressure, state_.last_pressure);
  }
  stage.time = state_.time + stage.offset;
  return stage;
}

// The trial from which a stage starts: velocities extrapolated, activations where they are given.
Trial Simulation::stage_trial(const Stage& stage) {
  const SceneOptions& scene = system_.scene().options();
  Trial trial;
  trial.velocity_share = 1.0 / stage.hg;
  trial.elastic_share = 1.0 + scene.damping.beta / stage.hg;
  trial.mass_rate = 1.0 / stage.hg + scene.damping.alpha;
  trial.activation_follows = !delayed();
  trial.rate_gain = scene.reflex && !delayed() ? scene.reflex->velocity_gain : 0.0;
  trial.positions = state_.positions;
  trial.velocities = state_.velocities;
  trial.pressure = state_.pressure;
  trial.activation = state_.activation;
  const double growth = state_.last_step > 0.0 ? stage.offset / state_.last_step : 0.0;
  for (std::size_t k = 0; k < trial.positions.size(); ++k) {
    if (!system_.free()[k]) continue;
    double velocity = state_.velocities[k];
    if (growth > 0.0) velocity += growth * (velocity - state_.last_velocities[k]);
    trial.positions[k] = stage.base_positions[k] + stage.hg * velocity;
  }
  system_.place_tied(trial.positions);
  std::vector<double> factors = state_.stiffening;
  if (delayed()) {
    given_activation(stage.time, false, trial.activation);
    factors = stiffening_of(trial.activation);
  } else
    system_.set_command(commands_.at(stage.time, false));
  trial.isochoric_scale = std::move(factors);
  const double beta = scene.damping.in_momentum(), share = 1.0 + beta / stage.hg;
  for (std::size_t e = 0; e < trial.isochoric_scale.size(); ++e)
    trial.isochoric_scale[e] = share * trial.isochoric_scale[e] - (stage.rate.empty() ? 0.0 : beta * stage.rate[e]);
  trial.viscosity = scene.damping.viscosity();
  if (trial.viscosity > 0.0) {
    trial.pressure_offset = stage.base_pressure;
    for (double& p : trial.pressure_offset) p *= -trial.viscosity / stage.hg;
  }
  return trial;
}

void Simulation::evaluate(const Stage& stage, Trial& trial) {
  ++report_.residuals;
  for (std::size_t k = 0; k < trial.positions.size(); ++k)
    trial.velocities[k] = system_.moving()[k] ? (trial.positions[k] - stage.base_positions[k]) / stage.hg : 0.0;
  system_.measure(trial);
  if (!delayed() && system_.muscles() && system_.scene().options().stiffening) {
    const double beta = system_.scene().options().damping.in_momentum(), share = 1.0 + beta / stage.hg;
    const std::vector<double> factors = stiffening_of(trial.activation);
    for (std::size_t e = 0; e < factors.size(); ++e)
      trial.isochoric_scale[e] = share * factors[e] - beta * (factors[e] - stage.base_stiffening[e]) / stage.span;
  }
  system_.force(trial, force_);
  for (std::size_t k = 0; k < force_.size(); ++k) force_[k] -= stage.base_momentum[k] / stage.hg;
  system_.reduce(trial, force_);
  residual_ = system_.norm_free(force_);
  scale_ = system_.force_scale();  // of this very state: a wild trial must not loosen the tolerance
}

bool Simulation::valid() const {
  return std::isfinite(residual_) && system_.elasticity().least_jacobian() > 0.0 && !system_.lost();
}

bool Simulation::renew_factor(const Stage& stage, const Trial& trial) {
  const bool done = system_.renew_factor(trial, trial.mass_rate / stage.hg, report_);
  const WallContact* contact = system_.contact();
  factor_ = done ? std::make_shared<const FactorPoint>(FactorPoint{stage.hg, stage.time, trial, stage.base_momentum,
                                                                   contact ? contact->state() : ContactState{}})
                 : nullptr;
  factor_stamp_ = system_.factor_stamp();
  anderson_.reset();
  return done;
}

// The factor of this movement again, after another solve has used the system's.
bool Simulation::remake_factor() {
  Trial trial = factor_->trial;
  if (!delayed()) system_.set_command(commands_.at(factor_->time, false));
  system_.measure(trial);
  WallContact* contact = system_.contact();
  ContactState present;
  if (contact != nullptr) {
    present = contact->state();
    contact->set_state(factor_->contact);
  }
  system_.force(trial, force_);
  for (std::size_t k = 0; k < force_.size(); ++k) force_[k] -= factor_->base_momentum[k] / factor_->hg;
  system_.reduce(trial, force_);
  const bool done = system_.renew_factor(trial, trial.mass_rate / factor_->hg, report_);
  if (contact != nullptr) contact->set_state(std::move(present));
  factor_stamp_ = system_.factor_stamp();
  return done;
}

// A Newton step as long as the force still resists it: with the friction bounds held a stage is nearly a convex
// minimisation, and its kinks (points that begin or cease to touch or to slide) lie where the slope jumps.
void Simulation::search(const Stage& stage, Trial& trial, const Vector& increment, double slope) {
  const Trial start = trial;
  double low = 0.0, high = 0.0, slope_low = slope, slope_high = 0.0, length = 1.0;
  for (int cut = 0; cut < longest_search; ++cut) {
    trial = start;
    system_.move(increment, length, trial.positions);
    evaluate(stage, trial);
    const double here = valid() ? system_.restrict_free(force_).dot(increment) : -slope;
    if (!(here > search_share * std::abs(slope))) {
      if (high == 0.0 || here > search_share * slope) return;
      low = length;
      slope_low = here;
    } else {
      high = length;
      slope_high = here;
    }
    const double secant = low - slope_low * (high - low) / (slope_high - slope_low);
    length = std::clamp(secant, low + 0.1 * (high - low), high - 0.1 * (high - low));
  }
}

bool Simulation::solve_stage(const Stage& stage, Trial& trial) {
  ++report_.iterations;
  if (iterate(stage, trial, false)) return true;
  if (options_.error_tolerance > 0.0 && stage.hg > worth_halving) {
    factor_.reset();
    too_long_ = true;
    return false;
  }
  // Once more from the start of the step, with a factor at every iteration.
  trial.positions = state_.positions;
  trial.pressure = state_.pressure;
  return iterate(stage, trial, true);
}

bool Simulation::iterate(const Stage& stage, Trial& trial, bool newton) {
  anderson_.reset();
  if (factor_ && factor_stamp_ != system_.factor_stamp()) {
    if (!remake_factor()) factor_.reset();
    if (!delayed()) system_.set_command(commands_.at(stage.time, false));
  }
  evaluate(stage, trial);
  if (!valid()) return false;
  const double ratio = factor_ ? factor_->hg / stage.hg : 0.0;
  bool fresh = false;
  if (newton || ratio < 0.5 || ratio > 2.0) {
    if (!renew_factor(stage, trial)) return false;
    fresh = true;
  }
  double best = residual_;
  for (int k = 0; k < (newton ? newton_limit : quasi_newton_limit); ++k) {
    const double goal = options_.tolerance * std::max(scale_, least_scale * trial.elastic_share);
    if (residual_ <= goal) {
      if (k > worth_renewing) factor_.reset();
      return true;
    }
    ++report_.quasi_newton;
    const Vector G = system_.restrict_free(force_);
    Vector F = G;
    if (newton)
      system_.newton_step(F);
    else
      system_.precondition(F);
    const Vector increment = newton ? F : anderson_.increment(system_.restrict_free(trial.positions), F, G);
    const bool hopeless = !(increment.cwiseAbs().maxCoeff() < largest_increment_);
    if (!fresh) previous_ = trial;
    if (!hopeless && newton)
      search(stage, trial, increment, G.dot(increment));
    else if (!hopeless) {
      system_.move(increment, 1.0, trial.positions);
      evaluate(stage, trial);
    }
    const bool failed = hopeless || !valid() || residual_ > 20.0 * best;
    const bool slow = !newton && k == slow_after;
    if ((failed || slow) && fresh) {
      if (failed) return false;
    } else if (failed || slow) {
      if (failed) {
        trial = previous_;
        evaluate(stage, trial);
      }
      if (!renew_factor(stage, trial)) return false;
      fresh = true;
      continue;
    }
    best = std::min(best, residual_);
    if (newton && !renew_factor(stage, trial)) return false;
  }
  return false;
}

// w at the end of a stage; the remaining residual is kept out of it, so that momentum balances exactly.
NodeField Simulation::stage_momentum(const Stage& stage, const Trial& trial) {
  const double beta = system_.scene().options().damping.in_momentum();
  const NodeField residual = force_;
  NodeField momentum(residual.size(), 0.0);
  if (beta > 0.0) {
    tissue_force(trial.positions, stiffening_of(trial.activation), 1.0, momentum);
    for (double& x : momentum) x *= beta;
  }
  system_.inertia().multiply(1.0, trial.velocities, momentum);
  for (std::size_t k = 0; k < momentum.size(); ++k)
    if (system_.free()[k]) momentum[k] -= stage.hg * residual[k];
  return momentum;
}

void Simulation::finish(const Stage& stage, const Trial& trial, double h, State& next) {
  next.time = state_.time + h;
  next.positions = trial.positions;
  next.velocities = trial.velocities;
  next.momentum = stage_momentum(stage, trial);
  next.momentum_rate.resize(next.momentum.size());
  for (std::size_t k = 0; k < next.momentum.size(); ++k)
    next.momentum_rate[k] = (next.momentum[k] - stage.base_momentum[k]) / stage.hg;
  next.stiffening = stiffening_of(trial.activation);
  next.activation = trial.activation;
  next.tension = system_.muscles() ? system_.muscles()->tensions() : std::vector<double>{};
  next.pressure = trial.pressure;
  system_.elasticity().set_pressure(next.pressure);
  next.pressure_rate = next.pressure;
  for (std::size_t e = 0; e < next.pressure.size(); ++e)
    next.pressure_rate[e] = (next.pressure[e] - stage.base_pressure[e]) / stage.hg;
  if (WallContact* contact = system_.contact()) {
    contact->tractions(next.contact_pressure, next.contact_drag);
    contact->end_increment();
    next.contact = contact->state();
  }
}

}  // namespace glossa
