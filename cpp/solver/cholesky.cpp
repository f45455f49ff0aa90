#include "solver/cholesky.hpp"

#include <cholmod.h>

#include <cmath>

#ifdef _OPENMP
#include <omp.h>
#endif

#include <stdexcept>
#include <string>

#ifdef GLOSSA_HAS_OPENBLAS
extern "C" void openblas_set_num_threads(int);
#endif

#include "solver/single_factor.hpp"

namespace glossa {
namespace {

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
  SingleFactor single;
  bool single_current = false;
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
  impl_->entries = common.lnz;
  impl_->flops = common.fl;
}

Cholesky::~Cholesky() = default;
Cholesky::Cholesky(Cholesky&&) noexcept = default;
Cholesky& Cholesky::operator=(Cholesky&&) noexcept = default;

bool Cholesky::factorise(const LowerColumns& matrix) {
  [[maybe_unused]] const SingleThread single;
  cholmod_common& common = impl_->common;
  // Not a number passes through BLAS without complaint.
  double sum = 0.0;
  for (const double x : matrix.value) sum += x;
  if (!std::isfinite(sum)) return false;
  cholmod_sparse view = lower(matrix.column_start, matrix.row, matrix.value.data());
  common.quick_return_if_not_posdef = 1;
  const int done = cholmod_factorize(&view, impl_->factor, &common);
  if (!done && common.status < CHOLMOD_OK) fail(common, "factorisation");
  impl_->single_current = false;
  return common.status != CHOLMOD_NOT_POSDEF && impl_->factor->minor == impl_->factor->n;
}

void Cholesky::solve(Vector& x) const {
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
  if (!impl_->single_current) {
    const cholmod_factor& factor = *impl_->factor;
    const auto ints = [](const void* p) { return static_cast<const Index*>(p); };
    impl_->single.copy(factor.nsuper, ints(factor.super), ints(factor.pi), ints(factor.s), ints(factor.px),
                       static_cast<const double*>(factor.x));
    impl_->single_current = true;
  }
  impl_->single.solve(x);
}

double Cholesky::factor_entries() const {
  return impl_->entries;
}
double Cholesky::factor_flops() const {
  return impl_->flops;
}

}  // namespace glossa
