// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/blas_threads.hpp"

#include <dlfcn.h>

namespace elastogen::fem {

void hold_blas_threads() {
  void* const set_threads = dlsym(RTLD_DEFAULT, "openblas_set_num_threads");
  if (set_threads) reinterpret_cast<void (*)(int)>(set_threads)(1);
}

}  // namespace elastogen::fem
