// SPDX-License-Identifier: Apache-2.0
// A sort on TBB. The order is that of the comparison alone where no two elements are equivalent, or
// equivalent ones are equal: then it does not depend on the number of threads.

#pragma once

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <functional>

namespace elastogen {

/// Sorts [begin, end) by `less`.
template <class Iterator, class Less = std::less<>>
void parallel_sort(Iterator begin, Iterator end, const Less& less = {}) {
#ifdef __SANITIZE_THREAD__
  std::sort(begin, end, less);  // as in core/parallel.hpp
#else
  tbb::parallel_sort(begin, end, less);
#endif
}

}  // namespace elastogen
