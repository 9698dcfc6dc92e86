#include "output/stored_zip.hpp"

#include <doctest/doctest.h>
#include <zip.h>

#include <array>
#include <string>

#include "files/out_file.hpp"
#include "tools/scratch_folder.hpp"

namespace stored_zip_test {

using namespace dvdx::tool;
using dvdx::test::ScratchFolder;

const std::array<std::string, 2> contents{"some bytes", "others"};

StoredZip archive_of_contents() {
  return {{{.name = "a.npy", .bytes = contents[0].size(), .permissions = 0666, .crc = 0x9F597F55},
           {.name = "b.npy", .bytes = contents[1].size(), .permissions = 0666, .crc = 0x20B9B7F6}}};
}

void write_by_libzip(const std::string& path) {
  zip_t* archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, nullptr);
  REQUIRE(archive != nullptr);
  for (std::size_t i = 0; i < contents.size(); ++i) {
    zip_source_t* source = zip_source_buffer(archive, contents[i].data(), contents[i].size(), 0);
    const zip_int64_t member = zip_file_add(archive, i == 0 ? "a.npy" : "b.npy", source, ZIP_FL_ENC_UTF_8);
    REQUIRE(member == static_cast<zip_int64_t>(i));
    zip_set_file_compression(archive, i, ZIP_CM_STORE, 0);
    zip_file_set_dostime(archive, i, 0, (1U << 5U) | 1U, 0);
  }
  REQUIRE(zip_close(archive) == 0);
}

// The members' bytes are holes without disk space, except for `last`, the beginning of the last member.
void write_sparse(const StoredZip& archive, const std::string& path, const std::string& last) {
  OutFile file(path, OutFile::Open::anew, path);
  const std::size_t count = archive.members.size();
  for (std::size_t i = count; i-- > 0;) file.put_at(archive.header_place(i), archive.header(i));
  file.put_at(archive.bytes_place(count - 1), last);
  file.put_at(archive.header_place(count), archive.directory());
  file.close();
}

void check_by_libzip(const StoredZip& archive, const std::string& path, const std::string& last) {
  zip_t* read = zip_open(path.c_str(), ZIP_RDONLY | ZIP_CHECKCONS, nullptr);
  REQUIRE(read != nullptr);
  const std::size_t count = archive.members.size();
  REQUIRE(zip_get_num_entries(read, 0) == static_cast<zip_int64_t>(count));
  for (std::size_t i = 0; i < count; ++i) {
    zip_stat_t stat;
    REQUIRE(zip_stat_index(read, i, 0, &stat) == 0);
    CHECK(archive.members[i].name == stat.name);
    CHECK(archive.members[i].bytes == stat.size);
    CHECK(archive.members[i].bytes == stat.comp_size);
  }
  zip_file_t* file = zip_fopen_index(read, count - 1, 0);
  REQUIRE(file != nullptr);
  std::string bytes(last.size() + 1, '\0');
  CHECK(zip_fread(file, bytes.data(), bytes.size()) == static_cast<zip_int64_t>(last.size()));
  CHECK(bytes.substr(0, last.size()) == last);
  CHECK(zip_fclose(file) == 0);  // the checksum is right
  zip_discard(read);
}

TEST_CASE("an archive of stored members has libzip's bytes, whatever order they are written in") {
  const ScratchFolder folder("stored-zip");
  write_by_libzip(folder / "b.zip");
  const StoredZip archive = archive_of_contents();
  OutFile file(folder / "a.zip", OutFile::Open::anew, folder / "a.zip");
  file.put_at(archive.header_place(2), archive.directory());
  for (const std::size_t i : {1U, 0U}) {
    file.put_at(archive.bytes_place(i), contents[i]);
    file.put_at(archive.header_place(i), archive.header(i));
  }
  file.close();
  CHECK(folder.read("a.zip") == folder.read("b.zip"));
}

TEST_CASE("libzip reads archives with sizes and places of 64 bits") {
  constexpr std::uint64_t large = std::uint64_t{1} << 32U;
  for (const std::uint64_t bytes : {large - 100, large - 1, large, large + 12}) {
    CAPTURE(bytes);
    const ScratchFolder folder("large-zip");
    StoredZip archive = archive_of_contents();
    archive.members[0].bytes = bytes;
    const std::string path = folder / "a.zip";
    write_sparse(archive, path, contents[1]);
    check_by_libzip(archive, path, contents[1]);
  }
}

TEST_CASE("an archive uses 64-bit fields only for members that need them") {
  StoredZip archive = archive_of_contents();
  const std::size_t small = archive.header(0).size();
  archive.members[0].bytes = 0xFFFFFFFE;
  CHECK(archive.header(0).size() == small);
  CHECK(archive.header(0)[4] == 10);
  archive.members[0].bytes = 0xFFFFFFFF;
  CHECK(archive.header(0).size() == small + 20);
  CHECK(archive.header(0)[4] == 45);
  CHECK(archive.header(1)[4] == 10);
}

}  // namespace stored_zip_test
