#include "scene/scene.hpp"

#include "bodies.hpp"

namespace glossa::test {
namespace {

template <class Change>
void refused(const std::string& message, Change&& change) {
  HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  SceneOptions options = muscular(mesh);
  change(options);
  CAPTURE(message);
  CHECK_THROWS_WITH_AS(Scene(std::move(mesh), std::move(options)), message.c_str(), InputError);
}

}  // namespace

TEST_CASE("scene: refuses parameters out of range, with name and value") {
  refused("tissue: c10 must be positive and finite, it is 0.000000", [](SceneOptions& o) { o.tissue.c10 = 0.0; });
  refused("tissue: c20 must be finite and not negative, it is -1.000000", [](SceneOptions& o) { o.tissue.c20 = -1.0; });
  refused("tissue: bulk modulus must be positive and finite, it is inf",
          [](SceneOptions& o) { o.tissue.kappa = std::numeric_limits<double>::infinity(); });
  refused("density must be positive and finite, it is -1.000000", [](SceneOptions& o) { o.density = -1.0; });
  refused("force law: c must be positive and finite, it is 0.000000", [](SceneOptions& o) { o.force_law.c = 0.0; });
  refused("damping: alpha must be finite and not negative, it is -1.000000",
          [](SceneOptions& o) { o.damping.alpha = -1.0; });
  refused("damping: beta must be finite and not negative, it is -1.000000",
          [](SceneOptions& o) { o.damping.beta = -1.0; });
  refused("reflex: delay must be finite and not negative, it is -1.000000",
          [](SceneOptions& o) { o.reflex->delay = -1.0; });
  refused("reflex: velocity gain must be finite and not negative, it is nan",
          [](SceneOptions& o) { o.reflex->velocity_gain = silent; });
  refused("gravity: its components must be finite", [](SceneOptions& o) { o.gravity = Vector3(0, silent, 0); });
  refused("threads must lie between 1 and 256, it is 0", [](SceneOptions& o) { o.threads = 0; });
  refused("free components: three per node are needed", [](SceneOptions& o) { o.free.pop_back(); });
}

TEST_CASE("scene: refuses fibres that do not fit the mesh") {
  refused("fibres: muscle, capacity, length factor, rest length and stiffened elements need one entry per fibre",
          [](SceneOptions& o) { o.fibres.capacity.pop_back(); });
  refused("fibre 2: muscle index out of range", [](SceneOptions& o) { o.muscle_count = 2; });
  refused("fibre 0: node index 28 is out of range", [](SceneOptions& o) { o.fibres.nodes.values[1] = 28; });
  refused("fibre 0: passes one node twice",
          [](SceneOptions& o) { o.fibres.nodes.values[1] = o.fibres.nodes.values[0]; });
  refused("fibre 1: force capacity must be positive and finite, it is 0.000000",
          [](SceneOptions& o) { o.fibres.capacity[1] = 0.0; });
  refused("fibre 1: length factor must be positive and finite, it is -2.000000",
          [](SceneOptions& o) { o.fibres.length_factor[1] = -2.0; });
  refused("fibre 1: rest length must be positive and finite, it is 0.000000",
          [](SceneOptions& o) { o.fibres.rest_length[1] = 0.0; });
  refused("fibre 0: stiffened element out of range", [](SceneOptions& o) { o.fibres.stiffened.values[0].element = 8; });
  refused("fibre 0: stiffening gain must be finite and not negative, it is -1.000000",
          [](SceneOptions& o) { o.fibres.stiffened.values[1].gain = -1.0; });
  refused("fibre 0: needs at least two nodes", [](SceneOptions& o) { o.fibres.nodes.start = {0, 1, 7, 10}; });
}

TEST_CASE("scene: outside points are held; lengths at rest are the rest lengths") {
  const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  const Scene scene(mesh, muscular(mesh));
  for (std::size_t i = 0; i < 3; ++i) CHECK(scene.options().free[3 * 27 + i] == 0);
  CHECK_WITHIN(worst_entry(scene.fibre_lengths(mesh.nodes()), scene.options().fibres.rest_length), 1e-15);
  CHECK(scene.weight().size() == mesh.nodes().size());
}

TEST_CASE("solver: systems are kept for the same choice, and the choice is checked") {
  const HexMesh mesh = block(2, 2, 2, 0.15, 0.01, 1);
  Solver solver(Scene(mesh, muscular(mesh)));
  const FreeMask& free = solver.scene().options().free;
  const auto first = solver.system(free, {true, false, true});
  CHECK(first == solver.system(free, {true, false, true}));
  CHECK(first != solver.system(free, {true, true, true}));
  CHECK(first->fibre_of() == std::vector<Index>{0, 2});
  CHECK(solver.system(free, {false, false, false})->muscles() == nullptr);
  CHECK_THROWS_WITH_AS((void)solver.system(FreeMask(3, 1), {true, true, true}),
                       "free components: three per node are needed", InputError);
  CHECK_THROWS_WITH_AS((void)solver.system(free, {true}), "commands: one per muscle is needed", InputError);
}

}  // namespace glossa::test
