#include "bindings/bind_scene.hpp"

#include <memory>

#include "bindings/arrays.hpp"
#include "core/instruction_set.hpp"
#include "scene/solver.hpp"

namespace glossa::python {
namespace {

template <class T>
Rows<T> rows(const std::vector<Index>& start, std::vector<T> values, const char* name) {
  require(!start.empty() && start.front() == 0 && start.back() == static_cast<Index>(values.size()),
          std::string(name) + ": row starts must begin with 0 and end with the number of values");
  for (std::size_t k = 1; k < start.size(); ++k)
    require(start[k] >= start[k - 1], std::string(name) + ": row starts must not decrease");
  Rows<T> result;
  result.start = start;
  result.values = std::move(values);
  return result;
}

/// Arrays of a dictionary by name.
struct Arrays {
  const py::dict& from;
  [[nodiscard]] std::vector<Index> ints(const char* key) const { return to_vector(from[key].cast<IntArray>()); }
  [[nodiscard]] std::vector<double> reals(const char* key) const { return to_vector(from[key].cast<DoubleArray>()); }
};

Macrofibres macrofibres(const py::dict& d) {
  Macrofibres fibres;
  const Arrays arrays{d};
  fibres.nodes = rows(arrays.ints("node_start"), arrays.ints("nodes"), "fibre nodes");
  fibres.muscle = arrays.ints("muscle");
  fibres.capacity = arrays.reals("capacity");
  fibres.length_factor = arrays.reals("length_factor");
  fibres.rest_length = arrays.reals("rest_length");
  const auto elements = arrays.ints("stiffened_elements");
  const auto gains = arrays.reals("stiffening_gains");
  require(elements.size() == gains.size(), "stiffened elements and gains must have one length");
  std::vector<Stiffened> stiffened;
  for (std::size_t k = 0; k < elements.size(); ++k) stiffened.push_back({elements[k], gains[k]});
  fibres.stiffened = rows(arrays.ints("stiffened_start"), std::move(stiffened), "stiffened elements");
  return fibres;
}

std::optional<ContactOptions> contact_options(const py::object& given) {
  if (given.is_none()) return std::nullopt;
  const auto d = given.cast<py::dict>();
  const Arrays arrays{d};
  ContactOptions contact;
  const auto nodes = arrays.ints("weight_node");
  const auto along = arrays.reals("weight_along"), across = arrays.reals("weight_across");
  require(along.size() == nodes.size() && across.size() == nodes.size(), "contact weights must have one length");
  std::vector<PointWeight> weights;
  for (std::size_t k = 0; k < nodes.size(); ++k) weights.push_back({nodes[k], along[k], across[k]});
  contact.points.weights = rows(arrays.ints("weight_start"), std::move(weights), "contact weights");
  contact.points.area = arrays.reals("area");
  contact.points.wall = arrays.ints("wall");
  contact.points.offset = arrays.reals("offset");
  for (const py::handle field : d["walls"]) contact.walls.push_back(field.cast<std::shared_ptr<DistanceField>>());
  contact.friction = d["friction"].cast<double>();
  return contact;
}

std::optional<Bone> bone_options(const py::object& given) {
  if (given.is_none()) return std::nullopt;
  const auto d = given.cast<py::dict>();
  const Arrays arrays{d};
  Bone bone;
  bone.ties = {arrays.ints("tied"), d["centre"].cast<Index>(), d["turn"].cast<Index>()};
  const auto mass_nodes = arrays.ints("mass_node");
  const auto masses = arrays.reals("mass");
  require(mass_nodes.size() == masses.size(), "bone: one node per mass is needed");
  for (std::size_t k = 0; k < masses.size(); ++k) bone.masses.push_back({mass_nodes[k], masses[k]});
  const auto on_bone = arrays.ints("spring_on_bone"), fixed = arrays.ints("spring_fixed");
  const auto stiffness = arrays.reals("spring_stiffness"), rest = arrays.reals("spring_rest");
  require(on_bone.size() == fixed.size() && on_bone.size() == stiffness.size() && on_bone.size() == rest.size(),
          "bone: springs need two nodes, a stiffness and a rest length each");
  for (std::size_t k = 0; k < rest.size(); ++k) bone.springs.push_back({on_bone[k], fixed[k], stiffness[k], rest[k]});
  return bone;
}

ElementKind element_kind(const std::string& name) {
  if (name == "Q1P0") return ElementKind::q1p0;
  if (name == "Q2P1") return ElementKind::q2p1;
  require(name == "Q1", "element must be 'Q1P0', 'Q1' or 'Q2P1', it is '" + name + "'");
  return ElementKind::q1;
}

std::unique_ptr<Solver> make_solver(const DoubleArray& nodes, const IntArray& hexahedra, const py::dict& fibres,
                                    const py::kwargs& given) {
  require(hexahedra.ndim() == 2 && hexahedra.shape(1) == 8, "hexahedra: shape must be (m, 8)");
  std::vector<Hexahedron> elements(static_cast<std::size_t>(hexahedra.shape(0)));
  for (std::size_t e = 0; e < elements.size(); ++e)
    std::copy(hexahedra.data() + 8 * e, hexahedra.data() + 8 * (e + 1), elements[e].begin());
  SceneOptions options;
  options.fibres = macrofibres(fibres);
  options.muscle_count = given["muscle_count"].cast<Index>();
  options.tissue = {given["c10"].cast<double>(), given["c20"].cast<double>(), given["bulk_modulus"].cast<double>()};
  options.density = given["density"].cast<double>();
  options.element = element_kind(given["element"].cast<std::string>());
  options.force_law.c = given["firing_gradient"].cast<double>();
  options.force_law.force_velocity = given["force_velocity"].cast<bool>();
  options.stiffening = given["stiffening"].cast<bool>();
  options.reflex.reset();
  if (!given["reflex"].is_none()) {
    const auto [delay, gain] = given["reflex"].cast<std::pair<double, double>>();
    options.reflex = Reflex{delay, gain};
  }
  const auto [alpha, beta, law] = given["damping"].cast<std::tuple<double, double, std::string>>();
  require(law == "material" || law == "tangent", "damping law must be material or tangent, got " + law);
  options.damping = {alpha, beta, law == "material" ? DampingLaw::material : DampingLaw::tangent};
  if (!given["gravity"].is_none()) {
    const auto g = given["gravity"].cast<std::array<double, 3>>();
    options.gravity = Vector3(g[0], g[1], g[2]);
  }
  options.contact = contact_options(given["contact"]);
  options.bone = bone_options(given["bone"]);
  options.free = to_vector(given["free"].cast<ByteArray>());
  options.threads = given["threads"].cast<int>();
  return std::make_unique<Solver>(Scene(HexMesh(to_field(nodes, "nodes"), std::move(elements)), std::move(options)));
}

Equilibrium run_equilibrate(Solver& solver, const DoubleArray& fractions, const DoubleArray& start,
                            const py::object& pressure, const DoubleArray& target, const ByteArray& free,
                            const py::object& load, const py::object& wall_start, const py::object& wall_shift,
                            const py::object& contact_pressure, double tolerance, double gap_tolerance,
                            int max_iterations, bool quasi_newton) {
  const auto nodes = static_cast<py::ssize_t>(solver.scene().mesh().node_count());
  const std::vector<double> command = to_vector(fractions);
  const std::shared_ptr<System> shared = solver.system(to_vector(free), commanded_muscles(command));
  System& system = *shared;
  system.set_command(command);
  system.set_load(load.is_none() ? NodeField{} : to_field(load.cast<DoubleArray>(), "loads", nodes));
  EquilibriumOptions options;
  options.tolerance = tolerance;
  options.max_iterations = max_iterations;
  options.quasi_newton = quasi_newton;
  options.interrupt = interrupted;
  options.gap_tolerance = gap_tolerance;
  const auto& contact = solver.scene().options().contact;
  options.wall_start = to_vectors(wall_start, "wall displacements");
  options.wall_shift = to_vectors(wall_shift, "wall displacements");
  if (contact && wall_start.is_none()) options.wall_start.assign(contact->walls.size(), Vector3::Zero());
  if (contact && wall_shift.is_none()) options.wall_shift.assign(contact->walls.size(), Vector3::Zero());
  if (!contact_pressure.is_none()) options.contact_start = to_vector(contact_pressure.cast<DoubleArray>());
  const NodeField from = to_field(start, "start", nodes);
  const NodeField to = to_field(target, "target", nodes);
  std::vector<double> p;
  if (!pressure.is_none()) p = to_vector(pressure.cast<DoubleArray>());
  require(p.empty() || p.size() == static_cast<std::size_t>(solver.scene().mesh().element_count()),
          "pressure: one value per hexahedron is needed");
  return released([&] { return equilibrate(system, from, p, to, options); });
}

}  // namespace

std::vector<bool> commanded_muscles(const std::vector<double>& fractions) {
  std::vector<bool> flags;
  for (const double x : fractions) {
    require(std::isnan(x) || (std::isfinite(x) && x > 0.0),
            "commands: lambda must be positive (NaN for a silent muscle), it is " + std::to_string(x));
    flags.push_back(!std::isnan(x));
  }
  return flags;
}

void bind_scene(py::module_& module) {
  py::class_<Solver>(module, "Solver",
                     "A scene with its solvers: elements, macrofibres and the effects that act. See glossa.Scene.")
      .def(py::init(&make_solver), py::arg("nodes"), py::arg("hexahedra"), py::arg("fibres"))
      .def("equilibrate", &run_equilibrate, py::kw_only(), py::arg("fractions"), py::arg("start"),
           py::arg("pressure") = py::none(), py::arg("target"), py::arg("free"), py::arg("load") = py::none(),
           py::arg("wall_start") = py::none(), py::arg("wall_shift") = py::none(),
           py::arg("contact_pressure") = py::none(), py::arg("tolerance") = 1e-8, py::arg("gap_tolerance") = 4.5e-5,
           py::arg("max_iterations") = 150, py::arg("quasi_newton") = true,
           "Static equilibrium; see glossa.Scene.equilibrate.");
  module.def("kernel_name", &kernel_name, "Instruction set of the element kernels on this machine.");
}

}  // namespace glossa::python
