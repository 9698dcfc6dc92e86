#include "output/stored_zip.hpp"

#include <algorithm>
#include <limits>

#include "files/bytes.hpp"

namespace dvdx::tool {
namespace {

constexpr std::uint64_t most_bytes =
    std::numeric_limits<std::uint32_t>::max();          // in 32 bits; this value means "look at the extra field"
constexpr std::uint16_t zip_version = 10;               // 1.0
constexpr std::uint16_t version_64 = 45;                // 4.5: sizes of 64 bits
constexpr std::uint16_t written_by = (3U << 8U) | 63U;  // Unix, 6.3
constexpr std::uint32_t plain_file = 0100000;           // with the permissions in Unix's mode

bool is_large(std::uint64_t number) { return number >= most_bytes; }

template <class T>
void append_least(std::string& bytes, std::uint64_t number) {
  append_bytes(bytes, static_cast<T>(std::min<std::uint64_t>(number, std::numeric_limits<T>::max())));
}

// Returns the extra field of numbers that do not fit into 32 bits; empty if all fit.
std::string extra_of(const std::vector<std::uint64_t>& large) {
  std::string bytes;
  if (large.empty()) return bytes;
  append_bytes<std::uint16_t>(bytes, 1);  // ZIP64
  append_bytes(bytes, static_cast<std::uint16_t>(large.size() * sizeof(std::uint64_t)));
  for (const auto number : large) append_bytes(bytes, number);
  return bytes;
}

// Appends the fields from the needed version to the lengths of name and extra field: header and directory share them.
void append_common(std::string& bytes, const ZipMember& member, const std::string& extra) {
  constexpr std::uint16_t first_date =
      (1U << 5U) | 1U;  // a fixed date, so that the same run gives the same bytes: 1 January 1980
  append_bytes(bytes, extra.empty() ? zip_version : version_64);
  append_bytes<std::uint16_t>(bytes, 0);  // flags
  append_bytes<std::uint16_t>(bytes, 0);  // stored
  append_bytes<std::uint16_t>(bytes, 0);  // midnight
  append_bytes(bytes, first_date);
  append_bytes(bytes, member.crc);
  append_least<std::uint32_t>(bytes, member.bytes);  // as stored
  append_least<std::uint32_t>(bytes, member.bytes);
  append_bytes(bytes, static_cast<std::uint16_t>(member.name.size()));
  append_bytes(bytes, static_cast<std::uint16_t>(extra.size()));
}

std::string entry_of(const ZipMember& member, std::uint64_t place) {
  std::vector<std::uint64_t> large;
  if (is_large(member.bytes)) large = {member.bytes, member.bytes};
  if (is_large(place)) large.push_back(place);
  const std::string extra = extra_of(large);
  std::string bytes("PK\1\2");
  append_bytes(bytes, written_by);
  append_common(bytes, member, extra);
  append_bytes<std::uint16_t>(bytes, 0);  // bytes of a comment
  append_bytes<std::uint16_t>(bytes, 0);  // the disk
  append_bytes<std::uint16_t>(bytes, 0);  // internal attributes
  append_bytes(bytes, (plain_file | member.permissions) << 16U);
  append_least<std::uint32_t>(bytes, place);
  return bytes + member.name + extra;
}

std::string end_64(std::uint64_t members, std::uint64_t bytes_of_entries, std::uint64_t place) {
  constexpr std::uint64_t bytes_behind = 44;  // of the record, behind this number
  std::string bytes("PK\6\6");
  append_bytes(bytes, bytes_behind);
  append_bytes(bytes, version_64);
  append_bytes(bytes, version_64);
  append_bytes<std::uint64_t>(bytes, 0);  // this disk and the directory's
  append_bytes(bytes, members);           // on this disk
  append_bytes(bytes, members);
  append_bytes(bytes, bytes_of_entries);
  append_bytes(bytes, place);
  bytes += "PK\6\7";
  append_bytes<std::uint32_t>(bytes, 0);  // the disk of the record above
  append_bytes(bytes, place + bytes_of_entries);
  append_bytes<std::uint32_t>(bytes, 1);  // disks
  return bytes;
}

std::string end_of(std::uint64_t members, std::uint64_t bytes_of_entries, std::uint64_t place) {
  std::string bytes = is_large(place) ? end_64(members, bytes_of_entries, place) : std::string();
  bytes += "PK\5\6";
  append_bytes<std::uint32_t>(bytes, 0);  // this disk and the directory's
  append_least<std::uint16_t>(bytes, members);
  append_least<std::uint16_t>(bytes, members);
  append_least<std::uint32_t>(bytes, bytes_of_entries);
  append_least<std::uint32_t>(bytes, place);
  append_bytes<std::uint16_t>(bytes, 0);  // bytes of a comment
  return bytes;
}

}  // namespace

std::string StoredZip::header(std::size_t member) const {
  const ZipMember& of = members[member];
  const std::string extra = is_large(of.bytes) ? extra_of({of.bytes, of.bytes}) : std::string();
  std::string bytes("PK\3\4");
  append_common(bytes, of, extra);
  return bytes + of.name + extra;
}

std::uint64_t StoredZip::header_place(std::size_t member) const {
  return member == 0 ? 0 : bytes_place(member - 1) + members[member - 1].bytes;
}

std::uint64_t StoredZip::bytes_place(std::size_t member) const { return header_place(member) + header(member).size(); }

std::string StoredZip::directory() const {
  std::string bytes;
  for (std::size_t i = 0; i < members.size(); ++i) bytes += entry_of(members[i], header_place(i));
  return bytes + end_of(members.size(), bytes.size(), header_place(members.size()));
}

}  // namespace dvdx::tool
