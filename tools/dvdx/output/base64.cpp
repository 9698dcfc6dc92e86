#include "output/base64.hpp"

#include <array>
#include <cstdint>
#include <cstring>

namespace dvdx::tool {
namespace {

constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

using Two = std::array<char, 2>;

// The two digits of every 12 bits: half the look-ups.
constexpr auto letters_of_12_bits = [] {
  std::array<Two, 4096> all{};
  for (std::size_t bits = 0; bits < all.size(); ++bits) all[bits] = {digits[bits >> 6U], digits[bits & 63U]};
  return all;
}();

std::uint32_t byte(std::string_view bytes, std::size_t i) {
  return i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0U;
}

}  // namespace

std::string base64(std::string_view bytes) {
  std::string text((bytes.size() + 2) / 3 * 4, '=');
  char* out = text.data();
  const std::size_t whole = bytes.size() / 3 * 3;
  for (std::size_t i = 0; i < whole; i += 3, out += 4) {
    const std::uint32_t word = (byte(bytes, i) << 16U) | (byte(bytes, i + 1) << 8U) | byte(bytes, i + 2);
    std::memcpy(out, letters_of_12_bits[word >> 12U].data(), 2);
    std::memcpy(out + 2, letters_of_12_bits[word & 4095U].data(), 2);
  }
  if (whole == bytes.size()) return text;
  const std::uint32_t word = (byte(bytes, whole) << 16U) | (byte(bytes, whole + 1) << 8U);
  for (unsigned digit = 0; digit <= bytes.size() - whole; ++digit) out[digit] = digits[(word >> (18 - 6 * digit)) & 63U];
  return text;
}

}  // namespace dvdx::tool
