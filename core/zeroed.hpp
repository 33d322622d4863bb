// SPDX-License-Identifier: Apache-2.0
// Vectors that are zero at first without a pass over them: for large ones the system provides pages
// of zeros when they are first touched. So a loop of many threads that fills a vector shares that
// work, and a vector that is never used needs no memory.

#pragma once

#include <cstddef>
#include <cstdlib>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace elastogen {

template <class T>
struct ZeroedAllocator {
  static_assert(std::is_trivially_copyable_v<T>);
  using value_type = T;

  ZeroedAllocator() = default;
  template <class U>
  ZeroedAllocator(const ZeroedAllocator<U>&) {}

  T* allocate(std::size_t n) {
    void* numbers = std::calloc(n, sizeof(T));
    if (!numbers) throw std::bad_alloc();
    return static_cast<T*>(numbers);
  }
  void deallocate(T* numbers, std::size_t) { std::free(numbers); }

  /// Does nothing: the memory is zero already.
  template <class U>
  void construct(U*) noexcept {}
  template <class U, class... Arguments>
  void construct(U* at, Arguments&&... arguments) {
    ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
  }

  bool operator==(const ZeroedAllocator&) const = default;
};

/// A vector that is sized once: numbers that it gets back after it shrank are not zero.
template <class T>
using Zeroed = std::vector<T, ZeroedAllocator<T>>;

}  // namespace elastogen
