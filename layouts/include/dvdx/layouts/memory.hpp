// The allocator of the library's buffers.
#pragma once

#include <cstddef>
#include <cstdint>

#include "dvdx/export.h"

namespace dvdx {

// The contents of new memory. Zeros are not written again, so the system provides no page before its use.
enum class Contents : std::uint8_t { anything, zeros };

// The caller's allocator; without functions, the C++ library's. `context` must live as long as the memory that was allocated.
struct Memory {
  // bytes > 0, boundary a power of two. Returns null if there is no memory: the call that asked then throws std::bad_alloc.
  using Allocate = void* (*)(void* context, std::size_t bytes, std::size_t boundary);
  using Release = void (*)(void* context, void* memory, std::size_t bytes, std::size_t boundary);

  Allocate allocate = nullptr;
  Release release = nullptr;
  void* context = nullptr;
  Contents contents = Contents::anything;  // of the memory that allocate returns
};

// Returns `bytes` bytes aligned to `boundary`. Throws std::bad_alloc if there is no memory.
[[nodiscard]] DVDX_EXPORT void* allocate(const Memory& memory, std::size_t bytes, std::size_t boundary);
DVDX_EXPORT void release(const Memory& memory, void* p, std::size_t bytes, std::size_t boundary) noexcept;

}  // namespace dvdx
