#include "core/instruction_set.hpp"
#include "effect/elasticity_kernel.hpp"
#include "effect/quadratic_kernel.hpp"

namespace glossa {

void sweep_forces(const ElasticSweep& sweep, int begin, int end) {
#ifdef GLOSSA_HAS_AVX2_KERNEL
  if (has_avx2()) return avx2::sweep_forces(sweep, begin, end);
#endif
  baseline::sweep_forces(sweep, begin, end);
}

void sweep_tangents(const ElasticSweep& sweep, int begin, int end) {
#ifdef GLOSSA_HAS_AVX2_KERNEL
  if (has_avx2()) return avx2::sweep_tangents(sweep, begin, end);
#endif
  baseline::sweep_tangents(sweep, begin, end);
}

void sweep_quadratic_forces(const QuadraticSweep& sweep, int begin, int end) {
#ifdef GLOSSA_HAS_AVX2_KERNEL
  if (has_avx2()) return avx2::sweep_quadratic_forces(sweep, begin, end);
#endif
  baseline::sweep_quadratic_forces(sweep, begin, end);
}

void sweep_quadratic_tangents(const QuadraticSweep& sweep, int begin, int end) {
#ifdef GLOSSA_HAS_AVX2_KERNEL
  if (has_avx2()) return avx2::sweep_quadratic_tangents(sweep, begin, end);
#endif
  baseline::sweep_quadratic_tangents(sweep, begin, end);
}

}  // namespace glossa
