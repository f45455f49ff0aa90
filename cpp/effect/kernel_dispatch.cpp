#include "effect/elasticity_kernel.hpp"

namespace glossa {
namespace {

bool has_avx2() {
#ifdef GLOSSA_HAS_AVX2_KERNEL
  static const bool answer = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  return answer;
#else
  return false;
#endif
}

}  // namespace

void sweep_elements(const ElasticSweep& sweep, int begin, int end) {
#ifdef GLOSSA_HAS_AVX2_KERNEL
  if (has_avx2()) return avx2::sweep_elements(sweep, begin, end);
#endif
  baseline::sweep_elements(sweep, begin, end);
}

const char* kernel_name() { return has_avx2() ? "avx2" : "baseline"; }

}  // namespace glossa
