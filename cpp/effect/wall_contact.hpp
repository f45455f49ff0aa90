// The tongue touches rigid walls: augmented Lagrangian contact with Coulomb friction at points of its smooth surface.
#pragma once

#include <memory>

#include "contact/contact_law.hpp"
#include "contact/contact_points.hpp"
#include "contact/distance_field.hpp"
#include "effect/effect.hpp"

namespace glossa {

/// What contact remembers between solves and steps; a value. Entries per contact point.
struct ContactState {
  std::vector<double> advance;  ///< m, of the wall towards the body: the multiplier of the gap
  // Only with friction:
  std::vector<double> pressure;    ///< Pa, at the last update: it bounds friction
  std::vector<Vector3> friction;   ///< Pa, drag of the tongue on the wall when the present increment began
  std::vector<Vector3> normal;     ///< of the wall at the last update
  std::vector<Vector3> slip_from;  ///< m, where each point was on its wall when the present increment began
};

/// Gap: signed distance of the wall at the point plus the point's offset. Pressure acts along the gradient of the
/// distance. Points that cannot have come near since they were last looked at are skipped, so that walls far away cost
/// one comparison each.
class WallContact final : public Effect {
 public:
  using Walls = std::vector<std::shared_ptr<const DistanceField>>;

  WallContact(const ContactPoints& points, const Walls& walls, const ContactLaw& law, int threads = 1);

  [[nodiscard]] const char* name() const override { return "contact"; }
  /// Groups of nodes that contact points couple, for the layout of the matrix; each group once.
  [[nodiscard]] const Rows<Index>& couplings() const { return groups_; }
  void bind(const BlockMatrix& matrix);

  void add_force(const Trial& trial, NodeField& force) override;
  /// The curvature of the walls pulls points in contact off unstable places: where it makes the tangent indefinite,
  /// `drop_negative_curvature` leaves its negative part out.
  void add_tangent(const Trial& trial, BlockMatrix& matrix) override;
  void drop_negative_curvature(bool drop) { drop_negative_ = drop; }
  [[nodiscard]] double energy(const Trial& trial) const override;
  /// K x of the last add_tangent, added to `product`.
  void multiply(const Trial& trial, const NodeField& x, NodeField& product) const;

  /// Moves the walls by these vectors (m) from where they were built.
  void set_shift(const std::vector<Vector3>& shift);
  /// Slip counts from these positions of body and walls on; friction starts from what the last increment ended with.
  void begin_increment(const NodeField& positions, const std::vector<Vector3>& shift);
  void end_increment();
  /// Largest distance (m) from gap >= 0, pressure >= 0, gap x pressure = 0 at the state of the last add_force: the
  /// deepest penetration, or the widest gap over which an advanced wall still pushes.
  [[nodiscard]] double violation() const;
  /// Error of the pressures that bound friction, over the sum of pressures; 0 without friction.
  [[nodiscard]] double bound_error() const;
  /// Deepest penetration (m) there.
  [[nodiscard]] double penetration() const;
  /// The wall advances where gaps are deeper than the tolerance (m), and steps back where they open again.
  void update(double gap_tolerance);
  /// Pressures that bound friction move by this share towards those of the last add_force.
  void update_bounds(double share);
  /// Whether add_force bounds friction by the pressures of its own trial, in the tangent planes there (Coulomb's law
  /// as it is, without potential), or by those of the last update.
  void follow_bounds(bool follow) { follow_bounds_ = follow; }
  /// Sets advances and friction bounds to those of an equilibrium at these positions in which the points are under
  /// these pressures (Pa).
  void resume(const NodeField& positions, const std::vector<double>& pressure);
  /// True if a point was so deep behind a wall at the last add_force that the way out is not known.
  [[nodiscard]] bool lost() const { return lost_; }
  [[nodiscard]] int active_count() const { return static_cast<int>(active_.size()); }
  /// Deepest point at the last add_force and its wall, -1 without.
  [[nodiscard]] Index deepest() const;

  [[nodiscard]] const ContactState& state() const { return state_; }
  void set_state(ContactState state);
  /// Forgets every pressure: nothing has touched yet.
  void clear();
  /// Pressure (Pa) and drag of the tongue on the wall (Pa) of every point at the last add_force.
  void tractions(std::vector<double>& pressure, std::vector<Vector3>& friction) const;

 private:
  struct Active {
    Index point = 0;
    double gap = 0.0;
    double depth = 0.0;  // m, that the law sees
    double pressure = 0.0;
    Vector3 position = Vector3::Zero();
    Vector3 gradient = Vector3::Zero();
    Vector3 trial = Vector3::Zero();  // drag before the bound
    double bound = 0.0;
  };
  void survey(const NodeField& positions);
  void measure(const NodeField& positions);
  void bind_friction(std::size_t k, double pressure, const Vector3& gradient);
  [[nodiscard]] double farthest_move(const NodeField& positions) const;
  [[nodiscard]] Matrix3 tangential(std::size_t k) const {
    return Matrix3::Identity() - state_.normal[k] * state_.normal[k].transpose();
  }
  [[nodiscard]] Matrix3 stiffness(const Active& active) const;

  const ContactPoints& points_;
  const Walls& walls_;
  ContactLaw law_;
  int threads_;
  ContactState state_;
  std::vector<Vector3> shift_;
  Rows<Index> groups_;
  std::vector<Index> group_;       // of each point
  std::vector<Index> slot_start_;  // per group
  std::vector<BlockMatrix::Slot> slots_;
  std::vector<double> reach_;      // of each point: how far it moves at most when no node moves more than 1 m
  std::vector<Index> nodes_;       // that carry contact points
  NodeField surveyed_at_;          // positions at which clearance_ was measured; empty: never
  std::vector<double> clearance_;  // m, gap of each point there
  std::vector<SplineCell> cells_;  // of the walls' distances, of each point
  std::vector<Active> near_;       // points that may touch at the last add_force
  std::vector<Active> active_;     // those that do
  bool drop_negative_ = false;
  bool follow_bounds_ = false;
  bool lost_ = false;
};

}  // namespace glossa
