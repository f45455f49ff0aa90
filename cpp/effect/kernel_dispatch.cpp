#include "core/instruction_set.hpp"
#include "effect/elasticity_kernel.hpp"

namespace glossa {

void sweep_elements(const ElasticSweep& sweep, int begin, int end) {
#ifdef GLOSSA_HAS_AVX2_KERNEL
  if (has_avx2()) return avx2::sweep_elements(sweep, begin, end);
#endif
  baseline::sweep_elements(sweep, begin, end);
}

}  // namespace glossa
