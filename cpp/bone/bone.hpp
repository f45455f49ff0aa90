// A bone that moves: the hyoid of the paper, rigid, held by springs, carrying the nodes that are tied to it.
#pragma once

#include <vector>

#include "core/types.hpp"

namespace glossa {

/// Nodes that follow a rigid body, and where its pose stands in a node field.
///
/// The pose is a pair of entries of the node field, like two more nodes: `centre` holds the position of the body's
/// centre (m), `turn` its rotation vector times the arm of the body (m; RigidMotion::arm), zero at rest. Their free
/// components are the degrees of freedom of the bone: six, or three in a mirrored half.
struct Ties {
  std::vector<Index> nodes;  ///< ascending, no node twice; never held
  Index centre = -1;
  Index turn = -1;
};

/// A mass (kg) at a tied node. A few of them stand for the inertia of the bone exactly: mass, centre and second
/// moments.
struct PointMass {
  Index node;
  double mass;
};

/// A linear spring (N/m, m) between a tied node and a fixed one; it pulls and pushes.
struct BoneSpring {
  Index on_bone;
  Index fixed;
  double stiffness;
  double rest_length;
};

struct Bone {
  Ties ties;
  std::vector<PointMass> masses;
  std::vector<BoneSpring> springs;
};

}  // namespace glossa
