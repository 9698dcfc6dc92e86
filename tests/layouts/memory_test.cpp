// Buffers from the caller's allocator.
#include "dvdx/layouts/memory.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "dvdx/layouts/aosoa.hpp"
#include "dvdx/layouts/soa.hpp"

namespace memory_test {

using namespace dvdx;

constexpr unsigned char mark = 0x3f;

void* take(void* context, std::size_t bytes, std::size_t boundary) {
  ++*static_cast<int*>(context);
  void* const memory = std::aligned_alloc(boundary, (bytes + boundary - 1) / boundary * boundary);
  if (memory != nullptr) std::memset(memory, mark, bytes);
  return memory;
}
void give_back(void* context, void* memory, std::size_t /*bytes*/, std::size_t /*boundary*/) {
  --*static_cast<int*>(context);
  std::free(memory);
}

TEST_CASE("buffers are zero, and are written only if the allocator does not promise zeros") {
  int blocks = 0;
  Memory memory{.allocate = take, .release = give_back, .context = &blocks};
  {
    const AlignedArray<double> zeros = aligned_array<double>(50, memory);
    CHECK(std::all_of(zeros.get(), zeros.get() + 50, [](double value) { return value == 0; }));
    memory.contents = Contents::zeros;
    const AlignedArray<double> as_given = aligned_array<double>(50, memory);
    unsigned char first = 0;
    std::memcpy(&first, as_given.get(), 1);
    CHECK(first == mark);
    CHECK(blocks == 2);
  }
  CHECK(blocks == 0);
}

TEST_CASE("states take their memory from the allocator that they are given") {
  int blocks = 0;
  const Memory memory{.allocate = take, .release = give_back, .context = &blocks};
  {
    Soa<float> columns(20, memory);
    Aosoa<float, 8> tiles(20, memory);
    CHECK(blocks == 2);
    CHECK(columns.view().x[2][19] == 0);
    CHECK(tiles.view().v[1][19] == 0);
  }
  CHECK(blocks == 0);
}

}  // namespace memory_test
