#include "scene/scene.hpp"

#include "../effect/touching.hpp"
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

TEST_CASE("scene: refuses contact points that do not fit body and walls") {
  static const Wall wall = roof(0.02);
  const auto refused_contact = [](const std::string& message, auto&& change) {
    refused(message, [&](SceneOptions& o) {
      o.contact = ContactOptions{top_points(2, 2, 2), {wall}, 0.1};
      change(*o.contact);
    });
  };
  refused_contact("contact points: area, wall and offset need one entry per point",
                  [](ContactOptions& c) { c.points.area.pop_back(); });
  refused_contact("friction must be finite and not negative, it is -0.100000",
                  [](ContactOptions& c) { c.friction = -0.1; });
  refused_contact("walls: a distance field is missing", [](ContactOptions& c) { c.walls.push_back(nullptr); });
  refused_contact("contact point 3: area must be positive and finite, it is 0.000000",
                  [](ContactOptions& c) { c.points.area[3] = 0.0; });
  refused_contact("contact point 2: its offset must be finite", [](ContactOptions& c) { c.points.offset[2] = silent; });
  refused_contact("contact point 1: wall index out of range", [](ContactOptions& c) { c.points.wall[1] = 1; });
  refused_contact("contact point 0: its nodes must exist and ascend",
                  [](ContactOptions& c) { c.points.weights.values[1].node = 18; });
  refused_contact("contact point 15: its nodes must exist and ascend",
                  [](ContactOptions& c) { c.points.weights.values.back().node = 28; });
  refused_contact("contact point 0: its weights must be finite",
                  [](ContactOptions& c) { c.points.weights.values[2].across = silent; });
}

TEST_CASE("scene: refuses a bone without pose, with masses or springs in the wrong place") {
  const auto refused_bone = [](const std::string& message, auto&& change) {
    HexMesh plain = block(2, 2, 2, 0.0, 0.01, 1);
    NodeField nodes = plain.nodes();
    for (const double x : {0.01, 0.01, 0.02, 0.0, 0.0, 0.0}) nodes.push_back(x);  // 28 and 29
    SceneOptions options;
    options.bone = Bone{{{18, 19, 20}, 28, 29}, {{18, 0.1}}, {{19, 27, 220.0, 0.03}}};
    change(*options.bone, nodes);
    CHECK_THROWS_WITH_AS(Scene(HexMesh(nodes, plain.hexahedra()), options), message.c_str(), InputError);
  };
  refused_bone("bone: no node is tied to it", [](Bone& b, NodeField&) { b.ties.nodes.clear(); });
  refused_bone("bone: tied nodes must exist and ascend", [](Bone& b, NodeField&) { b.ties.nodes = {18, 20, 20}; });
  refused_bone("bone: tied nodes must exist and ascend", [](Bone& b, NodeField&) { b.ties.nodes = {18, 30}; });
  refused_bone("bone: its pose needs two nodes of its own", [](Bone& b, NodeField&) { b.ties.turn = 28; });
  refused_bone("bone: its pose needs two nodes of its own", [](Bone& b, NodeField&) { b.ties.centre = 3; });
  refused_bone("bone: its pose needs two nodes of its own", [](Bone& b, NodeField&) { b.ties.turn = -1; });
  refused_bone("bone: its rotation must be zero at rest", [](Bone&, NodeField& nodes) { nodes[3 * 29] = 0.1; });
  refused_bone("bone: its masses must lie at tied nodes", [](Bone& b, NodeField&) { b.masses[0].node = 17; });
  refused_bone("bone: mass must be finite and not negative, it is -1.000000",
               [](Bone& b, NodeField&) { b.masses[0].mass = -1.0; });
  refused_bone("bone: a spring must start at a tied node", [](Bone& b, NodeField&) { b.springs[0].on_bone = 17; });
  refused_bone("bone: a spring must end at a fixed point", [](Bone& b, NodeField&) { b.springs[0].fixed = 3; });
  refused_bone("bone: spring stiffness must be finite and not negative, it is -1.000000",
               [](Bone& b, NodeField&) { b.springs[0].stiffness = -1.0; });
  refused_bone("bone: spring rest length must be finite and not negative, it is -1.000000",
               [](Bone& b, NodeField&) { b.springs[0].rest_length = -1.0; });
}

TEST_CASE("scene: a bone's weight joins that of the body, its tied nodes are not free, its pose is") {
  const HexMesh plain = block(1, 1, 1);
  NodeField nodes = plain.nodes();
  for (const double x : {0.005, 0.005, 0.01, 0.0, 0.0, 0.0}) nodes.push_back(x);
  const HexMesh mesh(nodes, plain.hexahedra());
  SceneOptions options;
  options.gravity = Vector3(0, 0, -10.0);
  const Scene without(mesh, options);
  options.bone = Bone{{{4, 5, 6, 7}, 8, 9}, {{4, 0.1}, {7, 0.05}}, {}};
  const Scene with(mesh, options);
  CHECK_WITHIN(std::abs(with.weight()[14] - without.weight()[14] + 1.0), 1e-15);
  CHECK_WITHIN(std::abs(with.weight()[23] - without.weight()[23] + 0.5), 1e-15);
  CHECK(with.weight()[17] == without.weight()[17]);
  for (std::size_t k = 0; k < 30; ++k) CHECK(with.options().free[k] == (k < 12 || k >= 24 ? 1 : 0));
  for (std::size_t k = 24; k < 30; ++k) CHECK(without.options().free[k] == 0);
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
