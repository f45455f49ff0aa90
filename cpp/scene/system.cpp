#include "scene/system.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/QR>

#include "core/error.hpp"
#include "muscle/stiffening.hpp"

namespace glossa {
namespace {

constexpr Index many_nodes = 2000;        // above it the fibres' stiffness to stretch stays out of the factor
constexpr double rough_tolerance = 0.03;  // of solves for quasi-Newton iterations then

double norm(const NodeField& field) {
  return Eigen::Map<const Vector>(field.data(), static_cast<Eigen::Index>(field.size())).norm();
}

Macrofibres chosen(const Macrofibres& all, const std::vector<bool>& commanded, std::vector<Index>& origin) {
  Macrofibres result;
  for (Index f = 0; f < all.count(); ++f) {
    const auto k = static_cast<std::size_t>(f);
    if (!commanded[static_cast<std::size_t>(all.muscle[k])]) continue;
    origin.push_back(f);
    result.nodes.values.insert(result.nodes.values.end(), all.nodes.begin(f), all.nodes.end(f));
    result.nodes.push_row();
    const auto first = all.segment_rest.begin() + all.nodes.start[k];
    result.segment_rest.insert(result.segment_rest.end(), first, first + all.nodes.length(f));
    result.stiffened.values.insert(result.stiffened.values.end(), all.stiffened.begin(f), all.stiffened.end(f));
    result.stiffened.push_row();
    result.muscle.push_back(all.muscle[k]);
    result.capacity.push_back(all.capacity[k]);
    result.length_factor.push_back(all.length_factor[k]);
    result.rest_length.push_back(all.rest_length[k]);
  }
  return result;
}

FreeMask with_ties(FreeMask free, const std::optional<Bone>& bone) {
  if (bone)
    for (const Index n : bone->ties.nodes)
      for (std::size_t i = 0; i < 3; ++i) free[3 * static_cast<std::size_t>(n) + i] = 1;
  return free;
}

std::unique_ptr<WallContact> contact_of(const Scene& scene) {
  const auto& contact = scene.options().contact;
  if (!contact || contact->points.count() == 0) return nullptr;
  return std::make_unique<WallContact>(contact->points, contact->walls, scene.contact_law(), scene.options().threads);
}

const std::vector<PointMass>& masses_of(const std::optional<Bone>& bone) {
  static const std::vector<PointMass> none;
  return bone ? bone->masses : none;
}

}  // namespace

System::System(const Scene& scene, FreeMask free, std::vector<bool> commanded, bool whole)
    : scene_(scene),
      free_(std::move(free)),
      moving_(with_ties(free_, scene.options().bone)),
      fibres_(chosen(scene.options().fibres, commanded, fibre_of_)),
      elasticity_(scene.mesh(), scene.batches(), scene.options().tissue, scene.options().element,
                  scene.options().threads),
      contact_(contact_of(scene)),
      inertia_(scene.batches()->cells, scene.mesh().node_count(), scene.masses(), masses_of(scene.options().bone)),
      stretch_apart_(!whole && scene.mesh().node_count() > many_nodes) {
  if (fibres_.count() > 0) muscles_.emplace(fibres_, scene.options().force_law);
  if (scene.options().bone) {
    motion_.emplace(scene.options().bone->ties, scene.mesh().nodes());
    springs_.emplace(scene.options().bone->springs);
  }
  if (!scene.weight().empty()) gravity_.emplace("gravity", scene.weight());
  use_layout(false);
  unknown_components_ = component_of_unknown();
  std::sort(unknown_components_.begin(), unknown_components_.end());
  set_load({});
}

void System::use_layout(bool touching) {
  std::unique_ptr<Layout>& wanted = layouts_[touching ? 1 : 0];
  if (wanted && wanted.get() == layout_) return;
  if (!wanted) {
    const auto& bone = scene_.options().bone;
    wanted = std::make_unique<Layout>(
        Layout{BlockMatrix(scene_.mesh().node_count(), free_, scene_.batches()->cells, couplings(touching),
                           &fill_reducing_order, bone ? &bone->ties : nullptr),
               std::nullopt, std::vector<Index>(free_.size(), -1)});
    const std::vector<Index>& component = wanted->matrix.component_of_unknown();
    for (std::size_t k = 0; k < component.size(); ++k)
      wanted->unknown_of_component[static_cast<std::size_t>(component[k])] = static_cast<Index>(k);
    wanted->matrix.set_mass(scene_.masses());
    for (const PointMass& point : masses_of(bone)) wanted->matrix.add_mass(point.node, point.mass);
    wanted->cholesky.emplace(wanted->matrix.columns(1));
  }
  layout_ = wanted.get();
  if (muscles_) muscles_->bind(layout_->matrix, !stretch_apart_);
  if (contact_ && touching) contact_->bind(layout_->matrix);
}

// Groups of nodes that effects couple beyond the elements.
Rows<Index> System::couplings(bool touching) const {
  Rows<Index> result;
  const auto add = [&](const Index* begin, const Index* end) {
    result.values.insert(result.values.end(), begin, end);
    result.push_row();
  };
  for (Index f = 0; f < fibres_.count(); ++f) {
    const Index *begin = fibres_.nodes.begin(f), *end = fibres_.nodes.end(f);
    if (!stretch_apart_)
      add(begin, end);
    else
      for (; begin + 1 < end; ++begin) add(begin, begin + 2);
  }
  if (touching)
    for (Index g = 0; g < contact_->couplings().size(); ++g)
      add(contact_->couplings().begin(g), contact_->couplings().end(g));
  return result;
}

// The fibres' stiffness to stretch in the unknowns, at the trial of the last assemble().
void System::collect_stretch(const Trial& trial) {
  stretch_.clear();
  NodeField field(free_.size(), 0.0);
  std::vector<Vector3> gradient;
  std::vector<Index> bone_nodes;
  if (motion_) {
    bone_nodes = motion_->ties().nodes;
    bone_nodes.insert(bone_nodes.end(), {motion_->ties().centre, motion_->ties().turn});
  }
  const auto collect = [&](Index node) {
    for (std::size_t c = 3 * static_cast<std::size_t>(node); c < 3 * static_cast<std::size_t>(node) + 3; ++c) {
      const Index unknown = layout_->unknown_of_component[c];
      if (unknown >= 0 && field[c] != 0.0) {
        stretch_.row.push_back(unknown);
        stretch_.value.push_back(field[c]);
      }
      field[c] = 0.0;
    }
  };
  for (Index f = 0; f < fibres_.count(); ++f) {
    const double axial = muscles_->stretch(trial, f, gradient);
    if (axial == 0.0) continue;
    for (Index a = 0; a < fibres_.nodes.length(f); ++a)
      Eigen::Map<Vector3>(field.data() + 3 * fibres_.nodes.begin(f)[a]) += gradient[static_cast<std::size_t>(a)];
    if (motion_) motion_->pull_back(trial.positions, field);
    for (Index a = 0; a < fibres_.nodes.length(f); ++a) collect(fibres_.nodes.begin(f)[a]);
    for (const Index node : bone_nodes) collect(node);
    stretch_.close(axial);
  }
}

void System::set_load(NodeField load) {
  load_.reset();
  load_norm_ = gravity_ ? norm(gravity_->load()) : 0.0;
  if (!load.empty()) {
    load_norm_ += norm(load);
    load_.emplace("loads", std::move(load));
  }
}

std::vector<double> System::lambda(const std::vector<double>& fractions) const {
  std::vector<double> result(fibres_.rest_length);
  for (std::size_t k = 0; k < result.size(); ++k) result[k] *= fractions[static_cast<std::size_t>(fibres_.muscle[k])];
  return result;
}

void System::set_command(const std::vector<double>& fractions) {
  if (muscles_) muscles_->set_lambda(lambda(fractions));
}

Trial System::rest_trial() const {
  Trial trial;
  trial.positions = scene_.mesh().nodes();
  trial.velocities.assign(trial.positions.size(), 0.0);
  trial.isochoric_scale.assign(elasticity_.padded_count(), 1.0);
  trial.pressure.assign(elasticity_.padded_count(), 0.0);
  trial.activation.assign(static_cast<std::size_t>(fibres_.count()), 0.0);
  return trial;
}

void System::measure(Trial& trial) {
  if (!muscles_) return;
  const Stopwatch watch(seconds_, Part::muscles);
  muscles_->measure(trial);
}

void System::stiffening(const Trial& trial, std::vector<double>& factors) const {
  factors.assign(elasticity_.padded_count(), 1.0);
  if (scene_.options().stiffening && muscles_)
    stiffening_factors(fibres_, trial.activation, scene_.options().force_law, factors);
}

void System::force(const Trial& trial, NodeField& sum) {
  sum.assign(trial.positions.size(), 0.0);
  {
    const Stopwatch watch(seconds_, Part::elasticity);
    elasticity_.add_force(trial, sum);
    force_scale_ = norm(sum) + trial.elastic_share * load_norm_;
  }
  if (muscles_) {
    const Stopwatch watch(seconds_, Part::muscles);
    muscles_->add_force(trial, sum);
  }
  if (contact_) {
    const Stopwatch watch(seconds_, Part::contact);
    contact_->add_force(trial, sum);
  }
  if (springs_) {
    const Stopwatch watch(seconds_, Part::hyoid);
    springs_->add_force(trial, sum);
  }
  const Stopwatch watch(seconds_, Part::inertia);
  inertia_.add_force(trial, sum);
  if (gravity_) gravity_->add_force(trial, sum);
  if (load_) load_->add_force(trial, sum);
}

void System::reduce(const Trial& trial, NodeField& sum) {
  if (!motion_) return;
  const Stopwatch watch(seconds_, Part::hyoid);
  bone_curvature_ = motion_->curvature(trial.positions, sum);
  motion_->pull_back(trial.positions, sum);
}

double System::energy(const Trial& trial) const {
  double sum = elasticity_.energy(trial);
  if (muscles_) sum += muscles_->energy(trial);
  if (contact_) sum += contact_->energy(trial);
  if (springs_) sum += springs_->energy(trial);
  if (gravity_) sum += gravity_->energy(trial);
  if (load_) sum += load_->energy(trial);
  return sum;
}

void System::assemble(const Trial& trial, double mass_scale) {
  const bool touching = contact_ && contact_->active_count() > 0;
  BlockMatrix* matrix = nullptr;
  {
    const Stopwatch watch(seconds_, Part::assembly);
    use_layout(touching);
    matrix = &layout_->matrix;
    elasticity_.set_mass_scale(mass_scale);
    elasticity_.add_tangent(trial, *matrix);
  }
  if (muscles_) {
    const Stopwatch watch(seconds_, Part::muscles);
    muscles_->add_tangent(trial, *matrix);
    if (stretch_apart_) collect_stretch(trial);
  }
  if (touching) {
    const Stopwatch watch(seconds_, Part::contact);
    contact_->add_tangent(trial, *matrix);
  }
  if (motion_) {
    const Stopwatch watch(seconds_, Part::hyoid);
    springs_->add_tangent(trial, *matrix);
    motion_->turn_gradients(trial.positions, turn_gradients_);
    matrix->eliminate(turn_gradients_);
    matrix->add(motion_->ties().turn, motion_->ties().turn, bone_curvature_);
  }
}

bool System::factorise(Report& report) {
  if (factorise_as_is(report)) return true;
  ++report.indefinite;
  return factorise_shifted(report);
}

bool System::renew_factor(const Trial& trial, double mass_scale, Report& report, bool whole_curvature) {
  const bool touching = contact_ && contact_->active_count() > 0;
  if (whole_curvature || !touching) {
    assemble(trial, mass_scale);
    if (factorise_as_is(report)) return true;
    ++report.indefinite;
  }
  if (touching) {
    contact_->drop_negative_curvature(true);
    assemble(trial, mass_scale);
    contact_->drop_negative_curvature(false);
    if (factorise_as_is(report)) return true;
  }
  return factorise_shifted(report);
}

bool System::factorise_as_is(Report& report) {
  const Stopwatch watch(seconds_, Part::factorisation);
  ++report.factorisations;
  ++factor_stamp_;
  const int threads = scene_.options().threads;
  return layout_->cholesky->factorise(layout_->matrix.columns(threads), threads);
}

bool System::factorise_shifted(Report& report) {
  const Stopwatch watch(seconds_, Part::factorisation);
  // Diagonal shift, growing from half a thousandth of the mean stiffness (soft bending needs a small one); the
  // direction stays one of descent.
  const int threads = scene_.options().threads;
  const LowerColumns& columns = layout_->matrix.columns(threads);
  double mean = 0.0;
  const std::size_t n = columns.column_start.size() - 1;
  for (std::size_t j = 0; j < n; ++j)
    mean += std::abs(columns.value[static_cast<std::size_t>(columns.column_start[j])]);
  mean /= static_cast<double>(n);
  if (!std::isfinite(mean)) return false;
  double shift = 5e-4 * mean;
  for (int attempt = 0; attempt < 7; ++attempt, shift *= 10.0) {
    layout_->matrix.shift_diagonal(shift);
    ++report.factorisations;
    if (layout_->cholesky->factorise(layout_->matrix.columns(threads), threads)) return true;
  }
  return false;
}

void System::newton_step(Vector& x, double tolerance) {
  const Stopwatch watch(seconds_, Part::solve);
  if (stretch_apart_ && !stretch_.weight.empty())
    layout_->cholesky->solve(x, tolerance, stretch_);
  else
    layout_->cholesky->solve(x, tolerance);
  x = -x;
}

void System::precondition(Vector& x) {
  const Stopwatch watch(seconds_, Part::solve);
  if (stretch_apart_ && !stretch_.weight.empty())
    layout_->cholesky->solve(x, rough_tolerance, stretch_);
  else
    layout_->cholesky->solve_roughly(x);
  x = -x;
}

void System::multiply(const Trial& trial, const NodeField& x, NodeField& product) const {
  elasticity_.multiply(x, product);
  if (muscles_) muscles_->multiply(trial, x, product);
  if (contact_) contact_->multiply(trial, x, product);
  if (springs_) springs_->multiply(trial, x, product);
  if (motion_) motion_->pull_back(trial.positions, product);
}

Vector System::restrict_free(const NodeField& field) const {
  const auto& component = component_of_unknown();
  Vector result(static_cast<Eigen::Index>(component.size()));
  for (std::size_t k = 0; k < component.size(); ++k)
    result(static_cast<Eigen::Index>(k)) = field[static_cast<std::size_t>(component[k])];
  return result;
}

void System::move(const Vector& increment, double length, NodeField& positions) const {
  const auto& component = component_of_unknown();
  for (std::size_t k = 0; k < component.size(); ++k)
    positions[static_cast<std::size_t>(component[k])] += length * increment(static_cast<Eigen::Index>(k));
  place_tied(positions);
}

NodeField System::spread(const Vector& increment, double length, const NodeField& positions) const {
  NodeField result(positions.size(), 0.0);
  const auto& component = component_of_unknown();
  for (std::size_t k = 0; k < component.size(); ++k)
    result[static_cast<std::size_t>(component[k])] = length * increment(static_cast<Eigen::Index>(k));
  if (motion_) motion_->spread(positions, result);
  return result;
}

void System::place_tied(NodeField& positions) const {
  if (motion_) motion_->place(positions);
}

double System::norm_free(const NodeField& field) const {
  double sum = 0.0;
  for (const Index c : unknown_components_)
    sum += field[static_cast<std::size_t>(c)] * field[static_cast<std::size_t>(c)];
  return std::sqrt(sum);
}

void require_supported(const HexMesh& mesh, const FreeMask& moving) {
  std::vector<std::array<double, 6>> rows;
  Vector3 centre = Vector3::Zero();
  for (Index n = 0; n < mesh.node_count(); ++n) centre += at(mesh.nodes(), n) / mesh.node_count();
  for (Index n = 0; n < mesh.node_count(); ++n) {
    if (mesh.outside(n)) continue;
    const Vector3 r = (at(mesh.nodes(), n) - centre) / 0.01;
    const std::array<std::array<double, 6>, 3> modes{
        {{1, 0, 0, 0, r.z(), -r.y()}, {0, 1, 0, -r.z(), 0, r.x()}, {0, 0, 1, r.y(), -r.x(), 0}}};
    for (std::size_t i = 0; i < 3; ++i)
      if (!moving[3 * static_cast<std::size_t>(n) + i]) rows.push_back(modes[i]);
  }
  Eigen::MatrixXd held(static_cast<Eigen::Index>(rows.size()), 6);
  for (std::size_t k = 0; k < rows.size(); ++k)
    for (std::size_t m = 0; m < 6; ++m) held(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(m)) = rows[k][m];
  Eigen::Index rank = 0;
  if (!rows.empty()) {
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(held);
    qr.setThreshold(1e-9);
    rank = qr.rank();
  }
  require(rank == 6, "constraints: the held nodes leave the body free to move rigidly (" + std::to_string(6 - rank) +
                         " of 6 rigid motions), so no equilibrium is unique; hold at least three nodes that are not on "
                         "one line");
}

}  // namespace glossa
