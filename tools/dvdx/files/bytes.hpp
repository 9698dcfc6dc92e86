// Numbers as the bytes of a binary file.
#pragma once

#include <array>
#include <bit>
#include <cstring>
#include <string>
#include <vector>

namespace dvdx::tool {

static_assert(std::endian::native == std::endian::little, "the binary files written here are little endian");

template <class T>
void append_bytes(std::string& bytes, T value) {
  const auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  bytes.append(raw.data(), raw.size());
}

template <class T>
[[nodiscard]] std::string bytes_of(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

}  // namespace dvdx::tool
