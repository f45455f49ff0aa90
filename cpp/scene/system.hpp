// The equations of a scene for one choice of held components and commanded muscles: effects, unknowns, factor.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "bone/rigid_motion.hpp"
#include "effect/bone_springs.hpp"
#include "effect/dead_load.hpp"
#include "effect/muscle_force.hpp"
#include "scene/scene.hpp"
#include "solver/cholesky.hpp"
#include "solver/report.hpp"

namespace glossa {

/// Holds the effects that act and the matrix that joins them. Muscles that are not commanded are not in it at all.
/// One System serves one solve at a time; scenes keep several for re-use of their layout and symbolic analysis.
class System {
 public:
  /// `free`: components that may move (a subset of the scene's). `commanded`: one flag per muscle. On bodies of many
  /// nodes the fibres' stiffness to stretch stays out of the factor, unless `whole`: it couples all nodes of a fibre
  /// and would make a factorisation 6 (resolution 2) to 17 times (resolution 4) as dear, where conjugate gradients
  /// with the factor of the rest need five to ten iterations.
  System(const Scene& scene, FreeMask free, std::vector<bool> commanded, bool whole = false);

  /// Replaces the external loads (N, node field; empty for none).
  void set_load(NodeField load);
  /// Motor commands as fractions of rest length, one per muscle; ignored for muscles not commanded.
  void set_command(const std::vector<double>& fractions);
  /// lambda (m) of the fibres of this system for such fractions.
  [[nodiscard]] std::vector<double> lambda(const std::vector<double>& fractions) const;

  /// A trial at rest with arrays of the right size.
  [[nodiscard]] Trial rest_trial() const;
  /// Measures fibres and, where the activation follows the trial, updates activations.
  void measure(Trial& trial);
  /// Stiffening factors s_e (padded) of the trial's activations; all 1 without stiffening.
  void stiffening(const Trial& trial, std::vector<double>& factors) const;
  /// Sum of the forces of all effects (N, node field) at the trial; needs measure() before.
  void force(const Trial& trial, NodeField& sum);
  /// Adds what the tied nodes feel, in the complete sum of forces, to the pose of the bone.
  void reduce(const Trial& trial, NodeField& sum);
  /// Energy (J) at the trial of the last force(), stiffening held.
  [[nodiscard]] double energy(const Trial& trial) const;
  /// Sizes of the potential terms of that energy, for judging rounding.
  [[nodiscard]] double force_scale() const { return force_scale_; }

  /// Assembles the tangent at the trial (after force() and reduce()) with `mass_scale` times the mass.
  void assemble(const Trial& trial, double mass_scale);
  /// Factorises the assembled tangent; on failure shifts its diagonal until it is positive definite.
  [[nodiscard]] bool factorise(Report& report);
  /// Both. Where the curvature of touched walls makes the tangent indefinite, its negative part is left out, and with
  /// `whole_curvature` false at once; the last resort is the shift.
  [[nodiscard]] bool renew_factor(const Trial& trial, double mass_scale, Report& report, bool whole_curvature = true);
  /// x <- - P^(-1) x with the tangent of the present factor, to a residual of `tolerance` |x| (Newton's step).
  void newton_step(Vector& x, double tolerance);
  /// The same as exactly as pays: nearly as with a factor in double precision, or, where the fibres' stiffness to
  /// stretch is not in the factor, to a hundredth.
  void newton_step(Vector& x) { newton_step(x, stretch_apart_ ? 1e-2 : 1e-10); }
  /// The same roughly, for quasi-Newton iterations.
  void precondition(Vector& x);
  /// K x for a node field, tangent of the last assemble (without mass).
  void multiply(const Trial& trial, const NodeField& x, NodeField& product) const;

  [[nodiscard]] Vector restrict_free(const NodeField& field) const;
  /// Moves the positions by `length` times an increment of the unknowns, tied nodes exactly.
  void move(const Vector& increment, double length, NodeField& positions) const;
  /// The same as a node field of increments from `positions`, tied nodes to first order.
  [[nodiscard]] NodeField spread(const Vector& increment, double length, const NodeField& positions) const;
  /// Puts the tied nodes where the pose says.
  void place_tied(NodeField& positions) const;
  [[nodiscard]] double norm_free(const NodeField& field) const;

  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] const FreeMask& free() const { return free_; }
  /// Components that move: the free ones and those of tied nodes.
  [[nodiscard]] const FreeMask& moving() const { return moving_; }
  [[nodiscard]] Elasticity& elasticity() { return elasticity_; }
  [[nodiscard]] const MuscleForce* muscles() const { return muscles_ ? &*muscles_ : nullptr; }
  [[nodiscard]] WallContact* contact() { return contact_.get(); }
  /// True if the trial of the last force() lies in no way out behind a wall.
  [[nodiscard]] bool lost() const { return contact_ && contact_->lost(); }
  [[nodiscard]] const Macrofibres& fibres() const { return fibres_; }
  /// Index in the scene of each fibre of this system.
  [[nodiscard]] const std::vector<Index>& fibre_of() const { return fibre_of_; }
  [[nodiscard]] const Inertia& inertia() const { return inertia_; }
  [[nodiscard]] Seconds& seconds() { return seconds_; }
  /// Changes with every factorisation: tells a user of the factor whether it is still his.
  [[nodiscard]] long factor_stamp() const { return factor_stamp_; }
  [[nodiscard]] const Cholesky& cholesky() const { return *layout_->cholesky; }
  /// Scalar matrix of the last assemble, for tests and figures.
  [[nodiscard]] const LowerColumns& columns() { return layout_->matrix.columns(scene_.options().threads); }
  /// Of the last assemble: touching and not touching number the unknowns differently.
  [[nodiscard]] const std::vector<Index>& component_of_unknown() const {
    return layout_->matrix.component_of_unknown();
  }

 private:
  /// A matrix, and the factor of its pattern. While nothing touches, the pattern goes without the couplings of
  /// contact, which more than double the work of a factorisation.
  struct Layout {
    BlockMatrix matrix;
    std::optional<Cholesky> cholesky;
    std::vector<Index> unknown_of_component;  // -1: none
  };
  [[nodiscard]] Rows<Index> couplings(bool touching) const;
  void collect_stretch(const Trial& trial);
  void use_layout(bool touching);
  bool factorise_as_is(Report& report);
  bool factorise_shifted(Report& report);

  const Scene& scene_;
  FreeMask free_, moving_;
  std::vector<Index> fibre_of_;  // filled while fibres_ is chosen
  Macrofibres fibres_;
  Elasticity elasticity_;
  std::optional<MuscleForce> muscles_;
  std::unique_ptr<WallContact> contact_;
  std::optional<RigidMotion> motion_;
  std::optional<BoneSprings> springs_;
  Inertia inertia_;
  std::optional<DeadLoad> gravity_;
  std::optional<DeadLoad> load_;
  std::vector<Index> unknown_components_;           // ascending
  std::array<std::unique_ptr<Layout>, 2> layouts_;  // without and with contact; made when first needed
  Layout* layout_ = nullptr;
  bool stretch_apart_;  // the fibres' stiffness to stretch is not in the matrix
  RankOnes stretch_;
  double force_scale_ = 0.0;
  double load_norm_ = 0.0;
  Matrix3 bone_curvature_ = Matrix3::Zero();
  std::vector<Matrix3> turn_gradients_;
  long factor_stamp_ = 0;
  Seconds seconds_;
};

/// Raises InputError if the components that do not move leave the body free to move rigidly.
void require_supported(const HexMesh& mesh, const FreeMask& moving);

}  // namespace glossa
