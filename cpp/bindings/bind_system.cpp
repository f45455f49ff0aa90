#include "bindings/arrays.hpp"
#include "bindings/bind_scene.hpp"
#include "scene/solver.hpp"

namespace glossa::python {
namespace {

/// The pieces below equilibrate and step: forces, tangent and factor of a scene at given positions, in statics.
class Pieces {
 public:
  Pieces(Solver& solver, const DoubleArray& fractions, const py::object& free, bool whole)
      : nodes_(solver.scene().mesh().node_count()) {
    const std::vector<double> command = to_vector(fractions);
    const FreeMask mask = free.is_none() ? solver.scene().options().free : to_vector(free.cast<ByteArray>());
    system_ = std::make_unique<System>(solver.scene(), mask, commanded_muscles(command), whole);
    system_->set_command(command);
    trial_ = system_->rest_trial();
  }

  py::array_t<double> force(const DoubleArray& positions) {
    trial_.positions = to_field(positions, "positions", nodes_);
    released([&] {
      system_->place_tied(trial_.positions);
      system_->measure(trial_);
      system_->stiffening(trial_, trial_.isochoric_scale);
      system_->force(trial_, force_);
      system_->reduce(trial_, force_);
      system_->elasticity().set_pressure(trial_.pressure);
      return 0;
    });
    evaluated_ = true;
    return to_array(force_, 3);
  }

  double energy() {
    need(evaluated_, "energy needs force() first");
    return system_->energy(trial_);
  }

  void assemble() {
    need(evaluated_, "assemble needs force() first");
    released([&] {
      system_->assemble(trial_, 0.0);
      return 0;
    });
    assembled_ = true;
  }

  py::tuple matrix() {
    need(assembled_, "matrix needs assemble() first");
    const LowerColumns& columns = system_->columns();
    return py::make_tuple(indices(columns.column_start), indices(columns.row), to_array(columns.value));
  }

  bool factorise() {
    need(assembled_, "factorise needs assemble() first");
    const int before = report_.indefinite;
    factorised_ = released([&] { return system_->factorise(report_); });
    return factorised_ && report_.indefinite == before;
  }

  py::array_t<double> solve(const DoubleArray& right, bool roughly) {
    need(factorised_, "solve needs a successful factorise() first");
    const auto& unknowns = system_->component_of_unknown();
    require(right.ndim() == 1 && right.shape(0) == static_cast<py::ssize_t>(unknowns.size()),
            "right side: one value per unknown is needed");
    Vector x = Eigen::Map<const Vector>(right.data(), right.shape(0));
    released([&] {
      if (roughly)
        system_->precondition(x);
      else
        system_->newton_step(x, 1e-15);
      return 0;
    });
    return to_array(std::vector<double>(x.data(), x.data() + x.size()));
  }

  [[nodiscard]] py::array_t<Index> unknowns() const { return indices(system_->component_of_unknown()); }
  [[nodiscard]] double factor_entries() const { return system_->cholesky().factor_entries(); }
  [[nodiscard]] double factor_flops() const { return system_->cholesky().factor_flops(); }

 private:
  static void need(bool done, const char* message) { require(done, message); }
  static py::array_t<Index> indices(const std::vector<Index>& list) {
    return py::array_t<Index>(static_cast<py::ssize_t>(list.size()), list.data());
  }

  py::ssize_t nodes_;
  std::unique_ptr<System> system_;
  Trial trial_;
  NodeField force_;
  Report report_;
  bool evaluated_ = false, assembled_ = false, factorised_ = false;
};

}  // namespace

void bind_system(py::module_& module) {
  py::class_<Pieces>(
      module, "Pieces",
      "Forces, tangent and factor of a scene at given positions (statics, stiffening following), one "
      "call each: for tests, benchmarks and own solvers. Call force, then assemble, then factorise. With whole False "
      "the matrix is that of the solvers, which leave the fibres' stiffness to stretch out where nodes are many.")
      .def(py::init<Solver&, const DoubleArray&, const py::object&, bool>(), py::keep_alive<1, 2>(), py::arg("solver"),
           py::arg("fractions"), py::arg("free") = py::none(), py::kw_only(), py::arg("whole") = true)
      .def("force", &Pieces::force, py::arg("positions"), "Sum of all static effects at the nodes, N (n, 3).")
      .def("energy", &Pieces::energy, "Potential energy, stiffening held, J.")
      .def("assemble", &Pieces::assemble, "Symmetric tangent at these positions.")
      .def("matrix", &Pieces::matrix, "Lower triangle: column starts, rows, values (N/m).")
      .def("factorise", &Pieces::factorise,
           "True if the tangent is positive definite as it is; else a shifted one is factorised in its place.")
      .def("solve", &Pieces::solve, py::arg("right"), py::kw_only(), py::arg("roughly") = false,
           "Minus the inverse of the tangent times a vector of the unknowns; roughly: in single precision.")
      .def_property_readonly("unknowns", &Pieces::unknowns, "Flat component 3 n + i of every unknown.")
      .def_property_readonly("factor_entries", &Pieces::factor_entries)
      .def_property_readonly("factor_flops", &Pieces::factor_flops);
}

}  // namespace glossa::python
