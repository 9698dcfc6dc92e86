#include "files/out_file.hpp"

#include <doctest/doctest.h>

#include <string>

#include "scene_io/fault.hpp"
#include "tools/scratch_folder.hpp"

namespace out_file_test {

using namespace dvdx::tool;
using dvdx::test::ScratchFolder;

std::string pattern(std::size_t bytes) {
  std::string text;
  for (std::size_t i = 0; i < bytes; ++i) text += static_cast<char>(i * i + i / 256);
  return text;
}

TEST_CASE("bytes written in any sizes and any order each stand at their place in the file") {
  const ScratchFolder folder("out-file");
  const std::string bytes = pattern(5'000'000);
  OutFile file(folder / "a", OutFile::Open::anew, "a");
  const std::size_t middle = 1'234'567;
  std::size_t at = middle;
  for (const std::size_t size : {3UL, 1UL << 20U, 1UL, (1UL << 20U) - 1, 0UL, 700'000UL}) {
    file.put_at(at, std::string_view(bytes).substr(at, size));
    at += size;
  }
  file.put_at(0, std::string_view(bytes).substr(0, middle));
  file.put_at(at, std::string_view(bytes).substr(at));
  file.close();
  CHECK(folder.read("a") == bytes);
}

TEST_CASE("an existing file can be written into, and a missing one is refused") {
  const ScratchFolder folder("out-file-there");
  folder.write("a", "0123456789");
  {
    OutFile file(folder / "a", OutFile::Open::as_it_is, "a");
    file.put_at(3, "abc");
    file.close();
  }
  CHECK(folder.read("a") == "012abc6789");
  { OutFile(folder / "a", OutFile::Open::anew, "a").close(); }
  CHECK(folder.read("a").empty());
  CHECK_THROWS_WITH_AS(OutFile(folder / "b", OutFile::Open::as_it_is, "its name"),
                       "its name: cannot be written: No such file or directory", Fault);
}

}  // namespace out_file_test
