// Where the library's buffers come from.
#pragma once

#include <cstddef>
#include <cstdint>

#include "dvdx/export.h"

namespace dvdx {

// The contents of memory when it is given: zeros need not be written again, so that no page is there before it is used.
enum class Contents : std::uint8_t { anything, zeros };

// The caller's allocator; without functions, the C++ library's. `context` must live as long as what was allocated.
struct Memory {
  // bytes > 0, boundary a power of two; null where there is no memory: the call that asked then throws std::bad_alloc.
  using Allocate = void* (*)(void* context, std::size_t bytes, std::size_t boundary);
  using Release = void (*)(void* context, void* memory, std::size_t bytes, std::size_t boundary);

  Allocate allocate = nullptr;
  Release release = nullptr;
  void* context = nullptr;
  Contents contents = Contents::anything;  // of what allocate gives
};

// bytes aligned to `boundary`. Throws std::bad_alloc where there is no memory.
[[nodiscard]] DVDX_EXPORT void* allocate(const Memory& memory, std::size_t bytes, std::size_t boundary);
DVDX_EXPORT void release(const Memory& memory, void* p, std::size_t bytes, std::size_t boundary) noexcept;

}  // namespace dvdx
