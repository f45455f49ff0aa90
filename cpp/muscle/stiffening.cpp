#include "muscle/stiffening.hpp"

#include <algorithm>

namespace glossa {

void stiffening_factors(const Macrofibres& fibres, const std::vector<double>& activation, const ForceLaw& law,
                        std::vector<double>& factors) {
  std::fill(factors.begin(), factors.end(), 1.0);
  const double top = law.saturation_activation();
  for (Index f = 0; f < fibres.count(); ++f) {
    const double a = std::min(activation[static_cast<std::size_t>(f)], top);
    if (a <= 0.0) continue;
    for (const Stiffened* s = fibres.stiffened.begin(f); s != fibres.stiffened.end(f); ++s)
      factors[static_cast<std::size_t>(s->element)] += s->gain * a;
  }
}

}  // namespace glossa
