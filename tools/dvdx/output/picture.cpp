#include "output/picture.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "output/deflate.hpp"

namespace dvdx::tool {
namespace {

constexpr std::size_t channels = 3;

// A PNG's numbers have the highest byte first.
template <class T>
void append_big(std::string& bytes, T value) {
  for (std::size_t i = sizeof(T); i > 0; --i) bytes += static_cast<char>((value >> (8 * (i - 1))) & 0xFFU);
}

std::string chunk(std::string_view name, std::string_view data) {
  std::string bytes;
  append_big(bytes, static_cast<std::uint32_t>(data.size()));
  bytes += name;
  bytes += data;
  const auto* const checked = reinterpret_cast<const Bytef*>(bytes.data()) + 4;  // NOLINT: zlib's bytes are unsigned
  append_big(bytes, static_cast<std::uint32_t>(crc32_z(0, checked, bytes.size() - 4)));
  return bytes;
}

std::string head(const Picture& picture) {
  std::string size;
  append_big(size, static_cast<std::uint32_t>(picture.width));
  append_big(size, static_cast<std::uint32_t>(picture.height));
  constexpr std::array<char, 5> form{8, 2, 0, 0, 0};  // 8 bits of red, green and blue; no interlacing
  size.append(form.data(), form.size());
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR", size);
}

// The neighbour that is nearest to left + above - corner.
int paeth(int left, int above, int corner) {
  const int wanted = left + above - corner;
  const int to_left = std::abs(wanted - left);
  const int to_above = std::abs(wanted - above);
  const int to_corner = std::abs(wanted - corner);
  if (to_left <= to_above && to_left <= to_corner) return left;
  return to_above <= to_corner ? above : corner;
}

// Returns a row as differences from the prediction of that filter which leaves the smallest differences.
std::string filtered(const std::uint8_t* row, const std::uint8_t* above, std::size_t bytes) {
  std::string best;
  std::size_t least = 0;
  for (const int filter : {0, 1, 2, 4}) {
    std::string line(1, static_cast<char>(filter));
    std::size_t size = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
      const int left = i < channels ? 0 : row[i - channels];
      const int up = above != nullptr ? above[i] : 0;
      const int corner = above != nullptr && i >= channels ? above[i - channels] : 0;
      const int foretold = filter == 0 ? 0 : filter == 1 ? left : filter == 2 ? up : paeth(left, up, corner);
      const auto rest = static_cast<std::int8_t>(static_cast<std::uint8_t>(row[i] - foretold));
      line += static_cast<char>(rest);
      size += static_cast<std::size_t>(std::abs(static_cast<int>(rest)));
    }
    if (!best.empty() && size >= least) continue;
    least = size;
    best = std::move(line);
  }
  return best;
}

// Returns the shorter of the plain rows, which suit flat colours, and the filtered rows.
std::string packed_rows(const Picture& picture) {
  const std::size_t bytes = channels * picture.width;
  std::string plain;
  std::string differences;
  for (std::size_t y = 0; y < picture.height; ++y) {
    const std::uint8_t* const row = picture.rgb.data() + y * bytes;
    plain += '\0';
    for (std::size_t i = 0; i < bytes; ++i) plain += static_cast<char>(row[i]);
    differences += filtered(row, y == 0 ? nullptr : row - bytes, bytes);
  }
  plain = deflated(plain);
  differences = deflated(differences);
  return plain.size() < differences.size() ? plain : differences;
}

}  // namespace

std::string png(const Picture& picture) { return head(picture) + chunk("IDAT", packed_rows(picture)) + chunk("IEND", ""); }

Picture with_fewer_colours(Picture picture) {
  constexpr int apart = 8;
  for (auto& byte : picture.rgb) byte = static_cast<std::uint8_t>(std::min(255, (byte + apart / 2) / apart * apart));
  return picture;
}

std::string AnimatedPng::add(const Picture& picture, double seconds) {
  const bool is_first = chunks_ == 0;
  std::string bytes;
  if (is_first) {
    std::string plays;
    append_big(plays, static_cast<std::uint32_t>(pictures_));
    append_big(plays, std::uint32_t{0});  // for ever
    bytes = head(picture) + chunk("acTL", plays);
  }
  std::string control;
  append_big(control, chunks_++);
  append_big(control, static_cast<std::uint32_t>(picture.width));
  append_big(control, static_cast<std::uint32_t>(picture.height));
  append_big(control, std::uint64_t{0});  // its offset
  append_big(control, static_cast<std::uint16_t>(std::clamp(std::round(1000 * seconds), 1.0, 65535.0)));
  append_big(control, std::uint16_t{1000});  // ms
  append_big(control, std::uint16_t{0});     // stays until the next one replaces it
  bytes += chunk("fcTL", control);
  if (is_first) return bytes + chunk("IDAT", packed_rows(picture));
  std::string data;
  append_big(data, chunks_++);
  return bytes + chunk("fdAT", data + packed_rows(picture));
}

std::string AnimatedPng::end() { return chunk("IEND", ""); }

}  // namespace dvdx::tool
