// A scene: a body, its muscles, and the effects that act on it. Immutable.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "bone/bone.hpp"
#include "effect/elasticity.hpp"
#include "effect/inertia.hpp"
#include "effect/wall_contact.hpp"
#include "muscle/force_law.hpp"
#include "muscle/macrofibre.hpp"
#include "muscle/reflex.hpp"

namespace glossa {

/// Walls, and the points of the body that may touch them.
struct ContactOptions {
  ContactPoints points;
  WallContact::Walls walls;
  double friction = 0.0;  ///< Coulomb's coefficient
};

/// Everything that defines a scene; plain data, checked by Scene.
struct SceneOptions {
  Yeoh tissue{1037.0, 486.0, 1.0369e6};  ///< Pa
  double density = 1040.0;               ///< kg/m3
  ElementKind element = ElementKind::q1p0;
  Macrofibres fibres;  ///< muscle indices 0 .. muscle_count - 1
  Index muscle_count = 0;
  ForceLaw force_law;
  bool stiffening = true;                   ///< eq. 1
  std::optional<Reflex> reflex = Reflex{};  ///< none: activation follows the length at once, without rate
  RayleighDamping damping;
  std::optional<Vector3> gravity;  ///< m/s2
  std::optional<ContactOptions> contact;
  std::optional<Bone> bone;  ///< its tied nodes move with it
  FreeMask free;             ///< 3 per node; 0 where the scene holds the component for good; ignored at tied nodes
  int threads = 1;
};

class Scene {
 public:
  /// Refuses, with InputError, what cannot work: sizes that do not fit, values out of range, fibres through missing
  /// nodes, stiffened elements out of range.
  Scene(HexMesh mesh, SceneOptions options);

  [[nodiscard]] const HexMesh& mesh() const { return mesh_; }
  [[nodiscard]] const SceneOptions& options() const { return options_; }
  [[nodiscard]] const std::shared_ptr<const RestBatches>& batches() const { return batches_; }
  [[nodiscard]] const std::vector<double>& masses() const { return masses_; }
  [[nodiscard]] const ContactLaw& contact_law() const { return contact_law_; }
  /// Consistent weight (N), that of the bone included; empty without gravity.
  [[nodiscard]] const NodeField& weight() const { return weight_; }
  /// Lengths of all fibres (m) at the given positions.
  [[nodiscard]] std::vector<double> fibre_lengths(const NodeField& positions) const;

 private:
  HexMesh mesh_;
  SceneOptions options_;
  std::shared_ptr<const RestBatches> batches_;
  std::vector<double> masses_;
  NodeField weight_;
  ContactLaw contact_law_;
};

}  // namespace glossa
