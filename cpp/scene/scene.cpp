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
  for (Index n = 0; n < mesh_.node_count(); ++n)
    if (mesh_.outside(n))
      for (std::size_t i = 0; i < 3; ++i) options_.free[3 * static_cast<std::size_t>(n) + i] = 0;
  check_fibres(mesh_, options_);
  soften_segments(options_.fibres, mesh_.nodes());
  batches_ = rest_batches(mesh_);
  masses_ = element_masses(mesh_, options_.density);
  if (options_.gravity) weight_ = gravity_load(mesh_, options_.density, *options_.gravity);
}

std::vector<double> Scene::fibre_lengths(const NodeField& positions) const {
  std::vector<double> lengths(static_cast<std::size_t>(options_.fibres.count()));
  for (Index f = 0; f < options_.fibres.count(); ++f)
    lengths[static_cast<std::size_t>(f)] = fibre_length(options_.fibres, f, positions);
  return lengths;
}

}  // namespace glossa
