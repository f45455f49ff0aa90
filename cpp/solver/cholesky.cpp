#include "solver/cholesky.hpp"

#include <cholmod.h>

#include <cmath>

#ifdef _OPENMP
#include <omp.h>
#endif

#include <optional>
#include <stdexcept>
#include <string>

#ifdef GLOSSA_HAS_OPENBLAS
extern "C" void openblas_set_num_threads(int);
#endif

#include "solver/single_factor.hpp"

namespace glossa {
namespace {

constexpr double dear = 1e9;           // operations of a factorisation
constexpr float slight_share = 1e-5f;  // of the diagonal: some hundred times the rounding of floats
constexpr int most_refinements = 12;   // that are cheaper than a factor in double precision
constexpr int most_iterations = 60;
constexpr double rounding = 1e-12;  // residual over right side that rounding may leave

// CHOLMOD builds with OpenMP ask for four threads in every small loop of a factorisation, which costs three times the
// factorisation itself. While an object of this class lives, such regions run on the calling thread.
class SingleThread {
 public:
#ifdef _OPENMP
  SingleThread() : levels_(omp_get_max_active_levels()) {
    omp_set_max_active_levels(0);
  }
  ~SingleThread() {
    omp_set_max_active_levels(levels_);
  }
  SingleThread(const SingleThread&) = delete;
  SingleThread& operator=(const SingleThread&) = delete;

 private:
  int levels_;
#endif
};

void start(cholmod_common& common) {
  cholmod_start(&common);
  common.print = 0;
  common.error_handler = nullptr;
  common.supernodal = CHOLMOD_SUPERNODAL;
  common.nmethods = 1;
#ifdef GLOSSA_HAS_OPENBLAS
  openblas_set_num_threads(1);
#endif
}

cholmod_sparse lower(const std::vector<Index>& column_start, const std::vector<Index>& row, const double* value) {
  cholmod_sparse view{};
  view.nrow = view.ncol = column_start.size() - 1;
  view.nzmax = row.size();
  view.p = const_cast<Index*>(column_start.data());
  view.i = const_cast<Index*>(row.data());
  view.x = const_cast<double*>(value);
  view.stype = -1;
  view.itype = CHOLMOD_INT;
  view.xtype = value != nullptr ? CHOLMOD_REAL : CHOLMOD_PATTERN;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = 1;
  view.packed = 1;
  return view;
}

// product = A x, A given by its lower triangle.
void multiply(const LowerColumns& matrix, const Vector& x, Vector& product) {
  product.setZero();
  for (Eigen::Index j = 0; j < x.size(); ++j) {
    const auto begin = matrix.column_start[static_cast<std::size_t>(j)];
    const auto end = matrix.column_start[static_cast<std::size_t>(j) + 1];
    const double xj = x(j);
    double sum = 0.0;
    for (Index k = begin; k < end; ++k) {
      const Index i = matrix.row[static_cast<std::size_t>(k)];
      const double a = matrix.value[static_cast<std::size_t>(k)];
      product(i) += a * xj;
      if (i != j) sum += a * x(i);
    }
    product(j) += sum;
  }
}

const Index* indices(const void* list) {
  return static_cast<const Index*>(list);
}

void fail(const cholmod_common& common, const char* doing) {
  const char* why = common.status == CHOLMOD_OUT_OF_MEMORY ? "out of memory" : "CHOLMOD error";
  throw std::runtime_error(std::string(doing) + ": " + why + " (status " + std::to_string(common.status) + ")");
}

}  // namespace

std::vector<Index> fill_reducing_order(const std::vector<Index>& column_start, const std::vector<Index>& row) {
  cholmod_common common;
  start(common);
  common.supernodal = CHOLMOD_SIMPLICIAL;
  // The cheapest of three orderings; which one wins depends on the mesh.
  common.nmethods = 3;
  common.method[0].ordering = CHOLMOD_METIS;
  common.method[1].ordering = CHOLMOD_NESDIS;
  common.method[2].ordering = CHOLMOD_AMD;
  common.postorder = 1;
  cholmod_sparse graph = lower(column_start, row, nullptr);
  cholmod_factor* factor = cholmod_analyze(&graph, &common);
  if (factor == nullptr) {
    const cholmod_common failed = common;
    cholmod_finish(&common);
    fail(failed, "ordering of the unknowns");
  }
  const auto* order = static_cast<const Index*>(factor->Perm);
  std::vector<Index> result(order, order + factor->n);
  cholmod_free_factor(&factor, &common);
  cholmod_finish(&common);
  return result;
}

struct Cholesky::Impl {
  cholmod_common common{};
  cholmod_factor* factor = nullptr;
  cholmod_dense* solution = nullptr;
  cholmod_dense* work_y = nullptr;
  cholmod_dense* work_e = nullptr;
  std::optional<SingleFactor> single;
  const LowerColumns* matrix = nullptr;  // of the last factorisation
  bool exact = false;                    // the factor in double precision is that of the matrix
  double entries = 0.0;
  double flops = 0.0;

  Impl() { start(common); }
  ~Impl() {
    cholmod_free_dense(&solution, &common);
    cholmod_free_dense(&work_y, &common);
    cholmod_free_dense(&work_e, &common);
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
};

Cholesky::Cholesky(const LowerColumns& matrix) : impl_(std::make_unique<Impl>()) {
  cholmod_common& common = impl_->common;
  common.method[0].ordering = CHOLMOD_NATURAL;
  common.postorder = 0;
  // Larger supernodes than the default: fewer, better filled calls of BLAS.
  common.nrelax[0] = 16;
  common.nrelax[1] = 48;
  common.nrelax[2] = 96;
  cholmod_sparse view = lower(matrix.column_start, matrix.row, matrix.value.data());
  impl_->factor = cholmod_analyze(&view, &common);
  if (impl_->factor == nullptr) fail(common, "symbolic analysis");
  const cholmod_factor& factor = *impl_->factor;
  impl_->single.emplace(
      SupernodalLayout(factor.nsuper, indices(factor.super), indices(factor.pi), indices(factor.s), matrix));
  impl_->entries = common.lnz;
  impl_->flops = common.fl;
}

Cholesky::~Cholesky() = default;
Cholesky::Cholesky(Cholesky&&) noexcept = default;
Cholesky& Cholesky::operator=(Cholesky&&) noexcept = default;

bool Cholesky::factorise(const LowerColumns& matrix, int threads) {
  // Not a number passes through BLAS without complaint.
  double sum = 0.0;
  for (const double x : matrix.value) sum += x;
  if (!std::isfinite(sum)) return false;
  impl_->matrix = &matrix;
  impl_->exact = false;
  if (impl_->single->factorise(matrix, threads)) return true;
  return impl_->flops < dear ? factorise_exactly() : impl_->single->factorise(matrix, threads, slight_share);
}

bool Cholesky::factorise_exactly() {
  [[maybe_unused]] const SingleThread single;
  cholmod_common& common = impl_->common;
  const LowerColumns& matrix = *impl_->matrix;
  cholmod_sparse view = lower(matrix.column_start, matrix.row, matrix.value.data());
  common.quick_return_if_not_posdef = 1;
  const int done = cholmod_factorize(&view, impl_->factor, &common);
  if (!done && common.status < CHOLMOD_OK) fail(common, "factorisation");
  const cholmod_factor& factor = *impl_->factor;
  if (common.status == CHOLMOD_NOT_POSDEF || factor.minor != factor.n) return false;
  impl_->single->copy(indices(factor.px), static_cast<const double*>(factor.x));
  impl_->exact = true;
  return true;
}

void Cholesky::solve(Vector& x, double tolerance) {
  if (!impl_->exact) {
    const Vector right = x;
    if (iterate(x, tolerance, most_refinements, nullptr)) return;
    x = right;
    if (!factorise_exactly()) return solve_roughly(x);
  }
  solve_exactly(x);
}

void Cholesky::solve(Vector& x, double tolerance, const RankOnes& more) {
  (void)iterate(x, tolerance, most_iterations, &more);
}

// Conjugate gradients for the matrix and, where given, more, preconditioned by the factor in single precision. False
// if they do not end within `most` iterations; x is the last iterate then.
bool Cholesky::iterate(Vector& x, double tolerance, int most, const RankOnes* more) {
  const double size = x.norm();
  if (!(size > 0.0)) return true;
  Vector residual = x, direction, image(x.size());
  x.setZero();
  double product = 0.0;
  for (int k = 0; k < most; ++k) {
    Vector z = residual;
    impl_->single->solve(z);
    const double next = residual.dot(z);
    direction = k == 0 ? z : Vector(z + (next / product) * direction);
    product = next;
    multiply(*impl_->matrix, direction, image);
    if (more != nullptr) more->add_product(direction, image);
    const double curvature = direction.dot(image);
    if (!(curvature > 0.0)) return false;
    x += (product / curvature) * direction;
    residual -= (product / curvature) * image;
    if (residual.norm() <= tolerance * size) return true;
  }
  return residual.norm() < std::max(tolerance, rounding) * size;
}

void Cholesky::solve_exactly(Vector& x) {
  [[maybe_unused]] const SingleThread single;
  cholmod_common& common = impl_->common;
  cholmod_dense b{};
  b.nrow = static_cast<std::size_t>(x.size());
  b.ncol = 1;
  b.nzmax = b.nrow;
  b.d = b.nrow;
  b.x = x.data();
  b.xtype = CHOLMOD_REAL;
  b.dtype = CHOLMOD_DOUBLE;
  if (!cholmod_solve2(CHOLMOD_A, impl_->factor, &b, nullptr, &impl_->solution, nullptr, &impl_->work_y, &impl_->work_e,
                      &common))
    fail(common, "triangular solve");
  const auto* from = static_cast<const double*>(impl_->solution->x);
  std::copy(from, from + x.size(), x.data());
}

void Cholesky::solve_roughly(Vector& x) {
  impl_->single->solve(x);
}

double Cholesky::factor_entries() const {
  return impl_->entries;
}
double Cholesky::factor_flops() const {
  return impl_->flops;
}

}  // namespace glossa
