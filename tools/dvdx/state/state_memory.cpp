#include "state/state_memory.hpp"

#include <cstdlib>
#include <cstring>

namespace dvdx::tool {
namespace {

// The address of the block is stored in front of the aligned memory that is given out.
void* take(void* /*context*/, std::size_t bytes, std::size_t boundary) {
  void* const block = std::calloc(1, bytes + boundary + sizeof(void*));
  if (block == nullptr) return nullptr;
  char* const first = static_cast<char*>(block) + sizeof(void*);
  const std::size_t past = reinterpret_cast<std::uintptr_t>(first) % boundary;
  char* const given = first + (past == 0 ? 0 : boundary - past);
  std::memcpy(given - sizeof block, &block, sizeof block);
  return given;
}

void give_back(void* /*context*/, void* memory, std::size_t /*bytes*/, std::size_t /*boundary*/) {
  void* block = nullptr;
  std::memcpy(&block, static_cast<char*>(memory) - sizeof block, sizeof block);
  std::free(block);
}

}  // namespace

constinit const Memory fresh_memory{.allocate = take, .release = give_back, .context = nullptr, .contents = Contents::zeros};

}  // namespace dvdx::tool
