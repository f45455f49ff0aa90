#include "effect/elasticity.hpp"

#include <algorithm>

#include <Eigen/LU>

#include "core/parallel.hpp"
#include "effect/quadratic_rest.hpp"
#include "mesh/hex_element.hpp"
#include "mesh/quadratic_hex.hpp"

namespace glossa {
namespace {

Matrix3 rest_jacobian(const HexMesh& mesh, const Hexahedron& element, const hex::CornerGradients& gradient) {
  Matrix3 jacobian = Matrix3::Zero();
  for (std::size_t a = 0; a < hex::corners; ++a)
    jacobian += at(mesh.nodes(), element[a]) * gradient.col(static_cast<Eigen::Index>(a)).transpose();
  return jacobian;
}

void fill_lane(const HexMesh& mesh, std::size_t element, RestBatch& batch, std::size_t lane) {
  const Hexahedron& corners = mesh.hexahedra()[element];
  batch.volume[lane] = 0.0;
  for (std::size_t q = 0; q < hex::points; ++q) {
    const hex::CornerGradients natural = hex::shape_gradient(hex::gauss_point(q));
    const Matrix3 jacobian = rest_jacobian(mesh, corners, natural);
    const Matrix3 inverse = jacobian.inverse();
    const hex::CornerGradients gradient = inverse.transpose() * natural;
    for (std::size_t a = 0; a < hex::corners; ++a)
      for (std::size_t i = 0; i < 3; ++i)
        batch.gradient[q][a][i][lane] = gradient(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(a));
    const Matrix3 metric = inverse * inverse.transpose();
    constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
    for (std::size_t m = 0; m < 6; ++m) batch.metric[q][m][lane] = metric(row[m], column[m]);
    batch.weight[q][lane] = jacobian.determinant();
    batch.volume[lane] += batch.weight[q][lane];
  }
  for (std::size_t a = 0; a < hex::corners; ++a) batch.corner[a][lane] = corners[a];
}

}  // namespace

std::shared_ptr<const RestBatches> rest_batches(const HexMesh& mesh, ElementKind kind) {
  auto rest = std::make_shared<RestBatches>();
  if (kind == ElementKind::q2p1) {
    QuadraticCells cells = quadratic_cells(mesh);
    rest->quadratic = quadratic_batches(mesh, cells);
    rest->cells = std::move(cells.cells);
    return rest;
  }
  const auto count = static_cast<std::size_t>(mesh.element_count());
  rest->cells = mesh.hexahedra();
  rest->linear.resize((count + lanes - 1) / lanes);
  for (std::size_t e = 0; e < rest->linear.size() * lanes; ++e)
    // Lanes beyond the last element repeat it; their results are never read.
    fill_lane(mesh, std::min(e, count - 1), rest->linear[e / lanes], e % lanes);
  return rest;
}

std::vector<double> element_masses(const HexMesh& mesh, const RestBatches& rest, double density) {
  return rest.is_quadratic() ? quadratic_masses(mesh, rest.cells, density) : element_masses(mesh, density);
}

std::vector<double> element_masses(const HexMesh& mesh, double density) {
  std::vector<double> masses;
  masses.reserve(36 * mesh.hexahedra().size());
  for (const Hexahedron& element : mesh.hexahedra()) {
    std::array<double, 36> pair_mass{};
    for (std::size_t q = 0; q < hex::points; ++q) {
      const auto xi = hex::gauss_point(q);
      const double w = density * rest_jacobian(mesh, element, hex::shape_gradient(xi)).determinant();
      const hex::CornerValues n = hex::shape(xi);
      std::size_t pair = 0;
      for (std::size_t b = 0; b < hex::corners; ++b)
        for (std::size_t a = 0; a <= b; ++a, ++pair) pair_mass[pair] += w * n[a] * n[b];
    }
    masses.insert(masses.end(), pair_mass.begin(), pair_mass.end());
  }
  return masses;
}

Elasticity::Elasticity(const HexMesh& mesh, std::shared_ptr<const RestBatches> batches, Yeoh law, ElementKind kind,
                       int threads)
    : mesh_(mesh),
      batches_(std::move(batches)),
      law_(law),
      kind_(kind),
      threads_(threads),
      padded_((mesh.hexahedra().size() + lanes - 1) / lanes * lanes) {
  const Cells& cells = batches_->cells;
  force_.resize(batches_->count() * lanes * cells.size * 4);
  for (auto* field : {&dilatation_, &isochoric_energy_, &volumetric_energy_, &least_jacobian_}) field->resize(padded_);
  no_offset_.assign(padded_, 0.0);
  positions_.assign(4 * static_cast<std::size_t>(mesh.node_count()), 0.0);
  velocities_ = positions_;
  source_start_.assign(static_cast<std::size_t>(mesh.node_count()) + 1, 0);
  for (const Index node : cells.nodes) ++source_start_[static_cast<std::size_t>(node) + 1];
  for (std::size_t n = 1; n < source_start_.size(); ++n) source_start_[n] += source_start_[n - 1];
  source_.resize(static_cast<std::size_t>(source_start_.back()));
  std::vector<Index> next(source_start_.begin(), source_start_.end() - 1);
  for (std::size_t k = 0; k < cells.nodes.size(); ++k)
    source_[static_cast<std::size_t>(next[static_cast<std::size_t>(cells.nodes[k])]++)] = static_cast<Index>(k);
}

void Elasticity::spread(const NodeField& field, std::vector<double>& four) const {
  for (std::size_t n = 0, count = field.size() / 3; n < count; ++n)
    for (std::size_t i = 0; i < 3; ++i) four[4 * n + i] = field[3 * n + i];
}

ElasticSweep Elasticity::sweep(const Trial& trial) {
  ElasticSweep sweep;
  spread(trial.positions, positions_);
  sweep.batches = batches_->linear.data();
  sweep.law = law_;
  sweep.mean_dilatation = kind_ != ElementKind::q1;
  sweep.positions = positions_.data();
  sweep.isochoric_scale = trial.isochoric_scale.data();
  sweep.volumetric_scale = trial.elastic_share;
  sweep.pressure = trial.pressure.data();
  sweep.pressure_offset = trial.pressure_offset.empty() ? no_offset_.data() : trial.pressure_offset.data();
  if (trial.viscosity > 0.0) {
    spread(trial.velocities, velocities_);
    sweep.velocities = velocities_.data();
    sweep.viscosity = trial.viscosity;
    sweep.viscous_share = trial.viscosity * trial.velocity_share;
    if (!sweep.mean_dilatation) sweep.volumetric_scale = 1.0;
  }
  sweep.force = force_.data();
  sweep.dilatation = dilatation_.data();
  sweep.isochoric_energy = isochoric_energy_.data();
  sweep.volumetric_energy = volumetric_energy_.data();
  sweep.least_jacobian = least_jacobian_.data();
  return sweep;
}

QuadraticSweep Elasticity::quadratic_sweep(const Trial& trial) {
  const ElasticSweep common = sweep(trial);
  QuadraticSweep result;
  result.batches = batches_->quadratic.data();
  result.law = common.law;
  result.positions = common.positions;
  result.isochoric_scale = common.isochoric_scale;
  result.volumetric_scale = common.volumetric_scale;
  result.pressure = common.pressure;
  result.pressure_offset = common.pressure_offset;
  result.velocities = common.velocities;
  result.viscosity = common.viscosity;
  result.viscous_share = common.viscous_share;
  result.force = common.force;
  result.dilatation = common.dilatation;
  result.isochoric_energy = common.isochoric_energy;
  result.volumetric_energy = common.volumetric_energy;
  result.least_jacobian = common.least_jacobian;
  return result;
}

void Elasticity::add_force(const Trial& trial, NodeField& force) {
  const auto batches = static_cast<int>(batches_->count());
  if (batches_->is_quadratic()) {
    const QuadraticSweep job = quadratic_sweep(trial);
    parallel_ranges(batches, threads_, [&](int begin, int end) { sweep_quadratic_forces(job, begin, end); });
  } else {
    const ElasticSweep job = sweep(trial);
    parallel_ranges(
        batches, threads_, [&](int begin, int end) { sweep_forces(job, begin, end); }, 8);
  }
  parallel_ranges(mesh_.node_count(), threads_, [&](int begin, int end) {
    for (auto n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end); ++n) {
      double sum[3] = {0.0, 0.0, 0.0};
      for (Index s = source_start_[n]; s < source_start_[n + 1]; ++s) {
        const double* from = force_.data() + 4 * static_cast<std::size_t>(source_[static_cast<std::size_t>(s)]);
        for (int i = 0; i < 3; ++i) sum[i] += from[i];
      }
      for (std::size_t i = 0; i < 3; ++i) force[3 * n + i] += sum[i];
    }
  });
}

void Elasticity::add_tangent(const Trial& trial, BlockMatrix& matrix) {
  const std::size_t padded_cells = batches_->count() * lanes;
  const auto batches = static_cast<int>(batches_->count());
  tangent_.resize(padded_cells * batches_->cells.pairs() * 9);
  volume_gradient_.resize(padded_cells * (batches_->is_quadratic() ? quadratic_moment_size : volume_gradient_size));
  if (batches_->is_quadratic()) {
    QuadraticSweep job = quadratic_sweep(trial);
    job.tangent = tangent_.data();
    job.moments = volume_gradient_.data();
    parallel_ranges(batches, threads_, [&](int begin, int end) { sweep_quadratic_tangents(job, begin, end); });
  } else {
    ElasticSweep job = sweep(trial);
    job.tangent = tangent_.data();
    job.volume_gradient = volume_gradient_.data();
    parallel_ranges(
        batches, threads_, [&](int begin, int end) { sweep_tangents(job, begin, end); }, 8);
  }
  matrix.gather(tangent_, mass_scale_, threads_);
}

double Elasticity::energy(const Trial& trial) const {
  double sum = 0.0;
  for (std::size_t e = 0; e < mesh_.hexahedra().size(); ++e)
    sum += trial.isochoric_scale[e] * isochoric_energy_[e] + trial.elastic_share * volumetric_energy_[e];
  return sum;
}

void Elasticity::multiply(const NodeField& x, NodeField& product) const {
  product.assign(x.size(), 0.0);
  const Cells& cells = batches_->cells;
  const double* block = tangent_.data();
  for (std::size_t c = 0; c < cells.count(); ++c) {
    const Index* nodes = cells.begin(c);
    for (std::size_t b = 0; b < cells.size; ++b)
      for (std::size_t a = 0; a <= b; ++a, block += 9) {
        const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> K(block);
        Eigen::Map<Vector3>(product.data() + 3 * nodes[a]) += K * at(x, nodes[b]);
        if (a != b) Eigen::Map<Vector3>(product.data() + 3 * nodes[b]) += K.transpose() * at(x, nodes[a]);
      }
  }
}

void Elasticity::predict_pressure(const NodeField& dx, double step, std::vector<double>& pressure) const {
  if (batches_->is_quadratic()) return predict_quadratic(dx, step, pressure);
  for (std::size_t e = 0; e < mesh_.hexahedra().size(); ++e) {
    const double* b = volume_gradient_.data() + e * volume_gradient_size;
    double change = 0.0;
    for (std::size_t a = 0; a < hex::corners; ++a)
      for (std::size_t i = 0; i < 3; ++i)
        change += b[3 * a + i] * dx[3 * static_cast<std::size_t>(mesh_.hexahedra()[e][a]) + i];
    const double predicted = law_.kappa * (dilatation_[e] - 1.0 + change / mesh_.volume(static_cast<Index>(e)));
    pressure[e] += step * (predicted - pressure[e]);
  }
}

void Elasticity::predict_quadratic(const NodeField& dx, double step, std::vector<double>& pressure) const {
  const Cells& cells = batches_->cells;
  for (std::size_t c = 0; c < cells.count(); ++c) {
    const QuadraticBatch& rest = batches_->quadratic[c / lanes];
    const std::size_t lane = c % lanes;
    const double* B = volume_gradient_.data() + c * quadratic_moment_size;
    Eigen::Vector4d moment = Eigen::Vector4d::Zero(), change = Eigen::Vector4d::Zero();
    for (Eigen::Index m = 0; m < 4; ++m)
      for (std::size_t a = 0; a < cells.size; ++a, B += 3)
        moment(m) += Eigen::Map<const Vector3>(B).dot(at(dx, cells.begin(c)[a]));
    for (std::size_t m = 0; m < 4; ++m)
      for (std::size_t n = 0; n < 4; ++n)
        change(static_cast<Eigen::Index>(m)) += rest.inverse_moment[m][n][lane] * moment(static_cast<Eigen::Index>(n));
    for (std::size_t o = 0; o < hex27::octants; ++o) {
      const auto e = static_cast<std::size_t>(rest.octant[o][lane]);
      double at_octant = change(0);
      for (std::size_t d = 0; d < 3; ++d)
        at_octant += ((o >> d & 1U) != 0 ? 0.5 : -0.5) * change(static_cast<Eigen::Index>(d) + 1);
      const double predicted = law_.kappa * (dilatation_[e] - 1.0 + at_octant);
      pressure[e] += step * (predicted - pressure[e]);
    }
  }
}

void Elasticity::set_pressure(std::vector<double>& pressure) const {
  for (std::size_t e = 0; e < mesh_.hexahedra().size(); ++e) pressure[e] = law_.pressure(dilatation_[e]);
}

double Elasticity::least_jacobian() const {
  return *std::min_element(least_jacobian_.begin(), least_jacobian_.begin() + mesh_.element_count());
}

Index Elasticity::worst_element() const {
  return static_cast<Index>(std::min_element(least_jacobian_.begin(), least_jacobian_.begin() + mesh_.element_count()) -
                            least_jacobian_.begin());
}

}  // namespace glossa
