#include "output/deflate.hpp"

#include <zlib.h>

#include <new>

namespace dvdx::tool {

std::string deflated(std::string_view bytes) {
  auto size = compressBound(bytes.size());
  std::string packed(size, '\0');
  const auto* from = reinterpret_cast<const Bytef*>(bytes.data());  // NOLINT: zlib's bytes are unsigned
  auto* to = reinterpret_cast<Bytef*>(packed.data());               // NOLINT
  if (compress2(to, &size, from, bytes.size(), Z_DEFAULT_COMPRESSION) != Z_OK) throw std::bad_alloc();  // no other is possible
  packed.resize(size);
  return packed;
}

}  // namespace dvdx::tool
