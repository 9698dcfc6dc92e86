#include "scene_io/mesh_file.hpp"

#include <doctest/doctest.h>

#include "scene_io/file_text.hpp"
#include "tools/scratch_folder.hpp"

namespace mesh_file_test {

using namespace dvdx;
using namespace dvdx::tool;

MeshFile mesh_of(std::string_view text) {
  const test::ScratchFolder folder("obj");
  folder.write("a.obj", text);
  return read_mesh(folder / "a.obj");
}

std::string fault_of(std::string_view text) {
  try {
    (void)mesh_of(text);
    return "";
  } catch (const FileFault& fault) {
    return fault.what();
  }
}

using Pairs = std::vector<Pair>;

TEST_CASE("vertices, faces and lines are read in every form of their indices") {
  const auto mesh = mesh_of(
      "# made by hand\nmtllib a.mtl\no sheet\nf 1/1/1 2//2 3/3\nv 0 0 0\nv\t1 0 0 1.0\r\nv 1 1 -2.5e-1 # corner\n"
      "v 0 1 0\nvn 0 0 1\nvt 0 0\n\nusemtl red\ns off\nf -4 -2 -1\nl 1 2 -1\nv 9 9 9\n");
  REQUIRE(mesh.vertices.size() == 5);
  CHECK(mesh.vertices[1] == Vec3{1, 0, 0});
  CHECK(mesh.vertices[2] == Vec3{1, 1, -0.25});
  CHECK(mesh.faces == std::vector<std::vector<std::uint32_t>>{{0, 1, 2}, {0, 2, 3}});
  CHECK(mesh.lines == Pairs{{0, 1}, {1, 3}});
  CHECK(edges_of(mesh) == Pairs{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}});
  CHECK(bends_of(mesh) == Pairs{{1, 3}});
  CHECK(diagonals_of(mesh).empty());
}

TEST_CASE("four-sided faces have diagonals and bend straight across their common side") {
  // 3 4 5
  // 0 1 2
  const auto mesh = mesh_of("v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nf 1 2 5 4\nf 5 2 3 6\n");
  CHECK(edges_of(mesh) == Pairs{{0, 1}, {0, 3}, {1, 2}, {1, 4}, {2, 5}, {3, 4}, {4, 5}});
  CHECK(diagonals_of(mesh) == Pairs{{0, 4}, {1, 3}, {1, 5}, {2, 4}});
  CHECK(bends_of(mesh) == Pairs{{0, 2}, {3, 5}});
}

TEST_CASE("faces of more than four sides have the diagonals of a fan, and its triangles bend") {
  const auto mesh = mesh_of("v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5\n");
  CHECK(edges_of(mesh).size() == 5);
  CHECK(diagonals_of(mesh) == Pairs{{0, 2}, {0, 3}});
  CHECK(bends_of(mesh) == Pairs{{1, 3}, {2, 4}});
}

TEST_CASE("a byte order mark, lines that go on and keywords in any case are read") {
  const auto marked = mesh_of("\xEF\xBB\xBFv 0 0 0\nV 1 0 0\nv 0 1 \\\n 0\nF 1 2 \\  \r\n\\\n3\n");
  CHECK(marked.vertices == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  CHECK(marked.faces == std::vector<std::vector<std::uint32_t>>{{0, 1, 2}});
  const auto older = mesh_of("v 0 0 0\nv 1 0 0\nv 0 1 0\nFo 1 2 3\nL 1 2\nfoo 1 2 3\n");
  CHECK(older.faces.size() == 1);
  CHECK(older.lines == Pairs{{0, 1}});
  CHECK(mesh_of("v 0 0 0 # goes on nowhere \\\nv 1 0 0\n").vertices.size() == 2);
  CHECK(mesh_of("v 0 0 0\\").vertices.size() == 1);
  CHECK(mesh_of("# as the first Macs ended lines\rv 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r").faces == marked.faces);
  CHECK(mesh_of("v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\n").faces == marked.faces);
  CHECK(fault_of("v 0 0 0\nf 1 \\\n2 9\n") == "line 3 names vertex 9: must be from 1 to 1, or count back from -1");
}

TEST_CASE("a closed surface bends across every edge, each pair once") {
  // Two four-sided pyramids, base to base: the apexes face each other across all four sides of the base.
  const auto mesh = mesh_of(
      "v 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"
      "f 2 1 6\nf 3 2 6\nf 4 3 6\nf 1 4 6\n");
  CHECK(edges_of(mesh).size() == 12);
  CHECK(bends_of(mesh) == Pairs{{0, 2}, {1, 3}, {4, 5}});
}

TEST_CASE("an error in an .obj file is named with its line") {
  CHECK(fault_of("# nothing\n") == "holds no vertex: must hold lines such as \"v 1 0 0.5\"");
  CHECK(fault_of("v 0 0\n") == "line 1 has 2 numbers: a vertex must have 3");
  CHECK(fault_of("v 0 0 0\nv 0 nan 0\n") == "line 2 holds nan: must be a finite number");
  CHECK(fault_of("v 0 0 0\nv 1 x 0\n") == "line 2 holds x: must be a finite number");
  CHECK(fault_of("v 0 0 0\nf 1 1\n") == "line 2 names 2 vertices: a face must name at least 3");
  CHECK(fault_of("v 0 0 0\nl 1\n") == "line 2 names 1 vertices: a line must name at least 2");
  CHECK(fault_of("v 0 0 0\nv 1 0 0\nl 1 1\n") == "line 3 joins vertex 1 to itself");
  CHECK(fault_of("v 0 0 0\nv 1 0 0\nf 1 2 1\n") == "line 3 names vertex 1 twice in a face");
  const std::string tail = ": must be from 1 to 2, or count back from -1";
  for (const char* index : {"0", "3", "-3", "1.5", "x", "", "1e99"}) {
    const std::string line = std::string("v 0 0 0\nv 1 0 0\nl 1 ") + index + "/1\n";
    CHECK(fault_of(line) == std::string("line 3 names vertex ") + index + tail);
  }
  CHECK(fault_of("v 0 0 0\nv 1 0 0\nf 1 2 99\nv 0 1 0\n") ==
        "line 3 names vertex 99: must be from 1 to 3, or count back from -1");
}

}  // namespace mesh_file_test
