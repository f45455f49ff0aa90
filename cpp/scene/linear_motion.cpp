#include "scene/linear_motion.hpp"

#include "core/error.hpp"

namespace glossa {
namespace {

constexpr double within_bound = 1.0 - 1e-9;  // a drag on its bound neither slides nor changes

}  // namespace

LinearMotion::LinearMotion(const Scene& scene, const std::vector<bool>& commanded, const std::vector<double>& fractions,
                           RestState rest)
    : system_(scene, scene.options().free, commanded) {
  require(rest.positions.size() == scene.mesh().nodes().size(), "linear motion: positions must fit the body");
  system_.set_command(fractions);
  rest_ = system_.rest_trial();
  rest_.positions = rest.positions;
  system_.place_tied(rest_.positions);
  system_.measure(rest_);
  rest_.activation_follows = false;
  system_.stiffening(rest_, rest_.isochoric_scale);
  rest.positions = rest_.positions;
  hold_contact(rest);
  evaluate(rest_);
  require(system_.elasticity().least_jacobian() > 0.0 && !system_.lost(),
          "linear motion: the positions hold an inverted hexahedron or lie behind a wall");
  system_.elasticity().set_pressure(rest_.pressure);
  system_.assemble(rest_, 0.0);  // settles the numbering of the unknowns
  for (std::size_t k = 0; k < rest_.activation.size(); ++k)
    if (rest_.activation[k] > 0.0) {
      own_.push_back(static_cast<Index>(k));
      active_.push_back(system_.fibre_of()[k]);
    }
}

void LinearMotion::hold_contact(const RestState& rest) {
  WallContact* contact = system_.contact();
  if (contact == nullptr) return;
  const auto& given = *system_.scene().options().contact;
  const auto points = static_cast<std::size_t>(given.points.count());
  require((rest.contact_pressure.empty() || rest.contact_pressure.size() == points) &&
              (rest.contact_drag.empty() || rest.contact_drag.size() == points) &&
              (rest.wall_shift.empty() || rest.wall_shift.size() == given.walls.size()),
          "linear motion: one pressure and drag per contact point and one displacement per wall are needed");
  const std::vector<Vector3> shift =
      rest.wall_shift.empty() ? std::vector<Vector3>(given.walls.size(), Vector3::Zero()) : rest.wall_shift;
  contact->set_shift(shift);
  if (!rest.contact_pressure.empty()) contact->resume(rest.positions, rest.contact_pressure);
  ContactState state = contact->state();
  if (!state.friction.empty() && !rest.contact_drag.empty())
    for (std::size_t k = 0; k < points; ++k) state.friction[k] = within_bound * rest.contact_drag[k];
  contact->set_state(std::move(state));
  contact->begin_increment(rest.positions, shift);
}

void LinearMotion::evaluate(const Trial& trial) {
  system_.force(trial, force_);
  system_.reduce(trial, force_);
}

// What the elastic part is multiplied by where velocity is `rate` times displacement.
double LinearMotion::share(double rate) const {
  return 1.0 + system_.scene().options().damping.beta * rate;
}

const LowerColumns& LinearMotion::matrix(double rate, double acceleration) {
  const RayleighDamping& damping = system_.scene().options().damping;
  evaluate(rest_);
  Trial trial = rest_;
  trial.velocity_share = rate;
  trial.elastic_share = share(rate);
  trial.viscosity = damping.viscosity();
  if (trial.viscosity > 0.0) {
    trial.pressure_offset = rest_.pressure;
    for (double& p : trial.pressure_offset) p *= -trial.viscosity * rate;
  } else
    for (double& s : trial.isochoric_scale) s *= share(rate);
  system_.assemble(trial, acceleration + damping.alpha * rate);
  return system_.columns();
}

std::vector<double> LinearMotion::activation() const {
  std::vector<double> result;
  for (const Index f : own_) result.push_back(rest_.activation[static_cast<std::size_t>(f)]);
  return result;
}

std::vector<double> LinearMotion::pulls() {
  const SceneOptions& scene = system_.scene().options();
  const Macrofibres& fibres = system_.fibres();
  std::vector<double> result;
  std::vector<Vector3> gradient;
  for (const Index f : own_) {
    const double activation = rest_.activation[static_cast<std::size_t>(f)];
    NodeField pull(rest_.positions.size(), 0.0);
    if (scene.stiffening && activation < scene.force_law.saturation_activation()) {
      Trial trial = rest_;
      trial.elastic_share = 0.0;
      trial.isochoric_scale.assign(trial.isochoric_scale.size(), 0.0);
      for (const Stiffened* s = fibres.stiffened.begin(f); s != fibres.stiffened.end(f); ++s)
        trial.isochoric_scale[static_cast<std::size_t>(s->element)] += s->gain;
      system_.elasticity().add_force(trial, pull);
    }
    const double slope = fibres.capacity[static_cast<std::size_t>(f)] * scene.force_law.level_slope(activation) *
                         scene.force_law.velocity_factor(0.0);
    fibre_gradient(fibres, f, rest_.positions, gradient);
    for (std::size_t a = 0; a < gradient.size(); ++a)
      Eigen::Map<Vector3>(pull.data() + 3 * fibres.nodes.begin(f)[a]) += slope * gradient[a];
    system_.reduce(rest_, pull);
    const Vector own = system_.restrict_free(pull);
    result.insert(result.end(), own.begin(), own.end());
  }
  return result;
}

std::vector<double> LinearMotion::gradients() {
  const Macrofibres& fibres = system_.fibres();
  std::vector<double> result;
  std::vector<Vector3> gradient;
  for (const Index f : own_) {
    NodeField field(rest_.positions.size(), 0.0);
    fibre_gradient(fibres, f, rest_.positions, gradient);
    for (std::size_t a = 0; a < gradient.size(); ++a)
      Eigen::Map<Vector3>(field.data() + 3 * fibres.nodes.begin(f)[a]) +=
          fibres.length_factor[static_cast<std::size_t>(f)] * gradient[a];
    system_.reduce(rest_, field);
    const Vector own = system_.restrict_free(field);
    result.insert(result.end(), own.begin(), own.end());
  }
  return result;
}

Vector LinearMotion::force(const Vector& displacement, const Vector& velocity, const std::vector<double>& activation) {
  const RayleighDamping& damping = system_.scene().options().damping;
  Trial trial = rest_;
  system_.move(displacement, 1.0, trial.positions);
  for (std::size_t k = 0; k < own_.size(); ++k) trial.activation[static_cast<std::size_t>(own_[k])] = activation[k];
  system_.stiffening(trial, trial.isochoric_scale);
  system_.measure(trial);
  evaluate(trial);
  system_.assemble(trial, 0.0);
  const NodeField rates = system_.spread(velocity, 1.0, trial.positions);
  NodeField damped(rates.size(), 0.0);
  if (damping.viscosity() > 0.0) {
    // The rate of the pressure, kappa / V b . v, as an offset.
    std::vector<double> pressure(trial.pressure.size(), 0.0);
    system_.elasticity().set_pressure(pressure);
    trial.pressure_offset = pressure;
    system_.elasticity().predict_pressure(rates, 1.0, pressure);
    for (std::size_t e = 0; e < pressure.size(); ++e)
      trial.pressure_offset[e] = damping.viscosity() * (pressure[e] - trial.pressure_offset[e]);
    trial.viscosity = damping.viscosity();
  } else {
    system_.elasticity().multiply(rates, damped);
    for (double& x : damped) x *= damping.beta;
  }
  trial.velocities = rates;
  trial.velocity_share = 1.0;
  trial.mass_rate = damping.alpha;
  system_.measure(trial);
  system_.force(trial, force_);
  for (std::size_t k = 0; k < force_.size(); ++k) force_[k] += damped[k];
  system_.reduce(trial, force_);
  return system_.restrict_free(force_);
}

}  // namespace glossa
