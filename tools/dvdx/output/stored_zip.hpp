// A ZIP archive (PKWARE's APPNOTE.TXT 6.3) of members that are stored as they are, in the same bytes as libzip 1.7 makes it.
// Libraries take members' bytes one member after the other. Here each member has its place before any byte is known, so that
// members grow side by side and several ranks write them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace dvdx::tool {

struct ZipMember {
  std::string name{};
  std::uint64_t bytes = 0;
  std::uint32_t permissions = 0644;
  std::uint32_t crc = 0;  // CRC-32 of its bytes; its place does not depend on it
};

struct StoredZip {
  std::vector<ZipMember> members;

  [[nodiscard]] std::uint64_t header_place(std::size_t member) const;
  [[nodiscard]] std::string header(std::size_t member) const;  // its bytes follow
  [[nodiscard]] std::uint64_t bytes_place(std::size_t member) const;
  [[nodiscard]] std::string directory() const;  // stands at header_place(members.size()), behind the last member
};

}  // namespace dvdx::tool
