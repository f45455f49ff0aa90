#include "scene/scene.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "effect/dead_load.hpp"

namespace glossa {
namespace {

void positive(double value, const char* name) {
  require(std::isfinite(value) && value > 0.0,
          std::string(name) + " must be positive and finite, it is " + std::to_string(value));
}

void not_negative(double value, const char* name) {
  require(std::isfinite(value) && value >= 0.0,
          std::string(name) + " must be finite and not negative, it is " + std::to_string(value));
}

void check_fibres(const HexMesh& mesh, const SceneOptions& options) {
  const Macrofibres& fibres = options.fibres;
  const auto count = static_cast<std::size_t>(fibres.count());
  require(fibres.muscle.size() == count && fibres.capacity.size() == count && fibres.length_factor.size() == count &&
              fibres.rest_length.size() == count && static_cast<std::size_t>(fibres.stiffened.size()) == count,
          "fibres: muscle, capacity, length factor, rest length and stiffened elements need one entry per fibre");
  for (Index f = 0; f < fibres.count(); ++f) {
    const auto k = static_cast<std::size_t>(f);
    const std::string which = "fibre " + std::to_string(f) + ": ";
    require(fibres.muscle[k] >= 0 && fibres.muscle[k] < options.muscle_count, which + "muscle index out of range");
    require(fibres.nodes.length(f) >= 2, which + "needs at least two nodes");
    std::vector<Index> visited(fibres.nodes.begin(f), fibres.nodes.end(f));
    std::sort(visited.begin(), visited.end());
    require(std::adjacent_find(visited.begin(), visited.end()) == visited.end(), which + "passes one node twice");
    for (const Index* n = fibres.nodes.begin(f); n != fibres.nodes.end(f); ++n)
      require(*n >= 0 && *n < mesh.node_count(), which + "node index " + std::to_string(*n) + " is out of range");
    positive(fibres.capacity[k], (which + "force capacity").c_str());
    positive(fibres.length_factor[k], (which + "length factor").c_str());
    positive(fibres.rest_length[k], (which + "rest length").c_str());
    for (const Stiffened* s = fibres.stiffened.begin(f); s != fibres.stiffened.end(f); ++s) {
      require(s->element >= 0 && s->element < mesh.element_count(), which + "stiffened element out of range");
      not_negative(s->gain, (which + "stiffening gain").c_str());
    }
  }
}

void check_contact(const HexMesh& mesh, const ContactOptions& contact) {
  const ContactPoints& points = contact.points;
  const auto count = static_cast<std::size_t>(points.count());
  require(points.area.size() == count && points.wall.size() == count && points.offset.size() == count,
          "contact points: area, wall and offset need one entry per point");
  not_negative(contact.friction, "friction");
  for (const auto& wall : contact.walls) require(wall != nullptr, "walls: a distance field is missing");
  for (Index k = 0; k < points.count(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    const std::string which = "contact point " + std::to_string(k) + ": ";
    positive(points.area[i], (which + "area").c_str());
    require(std::isfinite(points.offset[i]), which + "its offset must be finite");
    require(points.wall[i] >= 0 && static_cast<std::size_t>(points.wall[i]) < contact.walls.size(),
            which + "wall index out of range");
    Index last = -1;
    for (const PointWeight* w = points.weights.begin(k); w != points.weights.end(k); ++w) {
      require(w->node > last && w->node < mesh.node_count(), which + "its nodes must exist and ascend");
      require(std::isfinite(w->along) && std::isfinite(w->across), which + "its weights must be finite");
      last = w->node;
    }
  }
}

// Frees no tied node, and checks that pose, masses and springs are what bone.hpp says.
void check_bone(const HexMesh& mesh, const Bone& bone) {
  const Ties& ties = bone.ties;
  const auto exists = [&](Index n) { return n >= 0 && n < mesh.node_count(); };
  require(!ties.nodes.empty(), "bone: no node is tied to it");
  for (std::size_t k = 0; k < ties.nodes.size(); ++k)
    require(exists(ties.nodes[k]) && (k == 0 || ties.nodes[k - 1] < ties.nodes[k]),
            "bone: tied nodes must exist and ascend");
  const auto tied = [&](Index n) { return std::binary_search(ties.nodes.begin(), ties.nodes.end(), n); };
  require(exists(ties.centre) && exists(ties.turn) && ties.centre != ties.turn && mesh.outside(ties.centre) &&
              mesh.outside(ties.turn) && !tied(ties.centre) && !tied(ties.turn),
          "bone: its pose needs two nodes of its own");
  require(at(mesh.nodes(), ties.turn).isZero(), "bone: its rotation must be zero at rest");
  for (const PointMass& point : bone.masses) {
    require(tied(point.node), "bone: its masses must lie at tied nodes");
    not_negative(point.mass, "bone: mass");
  }
  for (const BoneSpring& spring : bone.springs) {
    require(tied(spring.on_bone), "bone: a spring must start at a tied node");
    require(exists(spring.fixed) && mesh.outside(spring.fixed) && !tied(spring.fixed),
            "bone: a spring must end at a fixed point");
    not_negative(spring.stiffness, "bone: spring stiffness");
    not_negative(spring.rest_length, "bone: spring rest length");
  }
}

}  // namespace

Scene::Scene(HexMesh mesh, SceneOptions options) : mesh_(std::move(mesh)), options_(std::move(options)) {
  positive(options_.tissue.c10, "tissue: c10");
  not_negative(options_.tissue.c20, "tissue: c20");
  positive(options_.tissue.kappa, "tissue: bulk modulus");
  positive(options_.density, "density");
  positive(options_.force_law.c, "force law: c");
  not_negative(options_.damping.alpha, "damping: alpha");
  not_negative(options_.damping.beta, "damping: beta");
  if (options_.reflex) {
    not_negative(options_.reflex->delay, "reflex: delay");
    not_negative(options_.reflex->velocity_gain, "reflex: velocity gain");
  }
  if (options_.gravity) require(options_.gravity->allFinite(), "gravity: its components must be finite");
  require(options_.threads >= 1 && options_.threads <= 256,
          "threads must lie between 1 and 256, it is " + std::to_string(options_.threads));
  if (options_.free.empty()) options_.free.assign(mesh_.nodes().size(), 1);
  require(options_.free.size() == mesh_.nodes().size(), "free components: three per node are needed");
  if (options_.bone) check_bone(mesh_, *options_.bone);
  const auto posed = [&](Index n) {
    return options_.bone && (n == options_.bone->ties.centre || n == options_.bone->ties.turn);
  };
  const auto hold = [&](Index n) {
    for (std::size_t i = 0; i < 3; ++i) options_.free[3 * static_cast<std::size_t>(n) + i] = 0;
  };
  for (Index n = 0; n < mesh_.node_count(); ++n)
    if (mesh_.outside(n) && !posed(n)) hold(n);
  if (options_.bone)
    for (const Index n : options_.bone->ties.nodes) hold(n);
  check_fibres(mesh_, options_);
  soften_segments(options_.fibres, mesh_.nodes());
  batches_ = rest_batches(mesh_, options_.element);
  masses_ = element_masses(mesh_, *batches_, options_.density);
  if (options_.gravity) {
    weight_ = batches_->is_quadratic() ? gravity_load(batches_->cells, masses_, mesh_.node_count(), *options_.gravity)
                                       : gravity_load(mesh_, options_.density, *options_.gravity);
    if (options_.bone)
      for (const PointMass& point : options_.bone->masses)
        Eigen::Map<Vector3>(weight_.data() + 3 * point.node) += point.mass * *options_.gravity;
  }
  if (options_.contact) {
    check_contact(mesh_, *options_.contact);
    // 0.4 GPa/m for the paper's tissue and size: a penetration of 0.01 mm under 4 kPa.
    contact_law_.stiffness = 30000.0 * options_.tissue.c10 / mesh_.extent();
    contact_law_.tangential_stiffness = 0.1 * contact_law_.stiffness;
    contact_law_.friction = options_.contact->friction;
  }
}

std::vector<double> Scene::fibre_lengths(const NodeField& positions) const {
  std::vector<double> lengths(static_cast<std::size_t>(options_.fibres.count()));
  for (Index f = 0; f < options_.fibres.count(); ++f)
    lengths[static_cast<std::size_t>(f)] = fibre_length(options_.fibres, f, positions);
  return lengths;
}

}  // namespace glossa
