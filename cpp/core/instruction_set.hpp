// Which of the kernels compiled for several instruction sets this processor can run.
#pragma once

namespace glossa {

/// True where the AVX2 kernels exist and the processor has AVX2 and FMA.
bool has_avx2();

/// "avx2" or "baseline".
inline const char* kernel_name() {
  return has_avx2() ? "avx2" : "baseline";
}

}  // namespace glossa
