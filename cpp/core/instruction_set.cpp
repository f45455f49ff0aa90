#include "core/instruction_set.hpp"

namespace glossa {

bool has_avx2() {
#ifdef GLOSSA_HAS_AVX2_KERNEL
  static const bool answer = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  return answer;
#else
  return false;
#endif
}

}  // namespace glossa
