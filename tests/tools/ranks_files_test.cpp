// Files and checkpoints of several ranks have the bytes of one rank's.
#include <doctest/doctest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <string>
#include <utility>
#include <vector>

#include "support/paths.hpp"
#include "tools/ranks.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace ranks::files_test {

// The list's indices are scattered over its ranks, and no rank writes the particles that it steps. Drops start with fewer
// particles than ranks.
TEST_CASE("ranks: every file has the bytes of one rank's" * doctest::skip(has_no_mpi)) {
  const MixedFolder folder("files");
  folder.write("list.json", list());
  folder.write("drops.json", drops());
  folder.write("playback.html", "<!-- dvdx data -->");
  const std::string viewer = "DVDX_VIEWER=.";
  const std::vector<std::string> kinds{"csv", "npz", "ply", "pc2", "vtp"};
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& kind : kinds) files.emplace_back("mixed", kind);
  for (const auto& kind : kinds) files.emplace_back("list", kind);
  files.emplace_back("list", "html");
  for (const char* kind : {"csv", "ply", "vtp", "html"}) files.emplace_back("drops", kind);
  for (const auto& of : files) {
    const std::string &scene = of.first, &kind = of.second;
    CAPTURE(scene);
    CAPTURE(kind);
    const std::string arguments = "run " + scene + ".json --every 2 --out ";
    const std::string alone = scene + "-" + kind;
    std::filesystem::create_directory(folder / alone);
    REQUIRE(run(folder, arguments + alone + "/all." + kind, viewer).exit == 0);
    const ScratchFolder parts("ranks-parts");
    const auto result = run(folder, arguments + (parts / "all.") + kind,
                            launcher(scene == "drops" ? 5
                                     : kind == "csv"  ? 2
                                                      : 3,
                                     viewer));
    CHECK_MESSAGE(result.exit == 0, result.err);
    CHECK(parts.entries() > 0);
    for (const auto& entry : std::filesystem::directory_iterator(folder / alone)) {
      const auto name = entry.path().filename().string();
      CHECK(folder.read(alone + "/" + name) == parts.read(name));
    }
  }
}

// A run in three ways: uninterrupted, with checkpoints, and resumed from the last one.
TEST_CASE("ranks: a run resumed on another number of ranks has the same bits, files, impacts and sums" *
          doctest::skip(has_no_mpi)) {
  const MixedFolder folder("resumed");
  folder.write("sheet.json", sheet());
  auto swept = nlohmann::json::parse(sheet());
  swept["network"]["rows"] = 200;
  swept["network"]["scheme"] = "sequential";
  swept["network"]["lines"] = "none";
  swept["duration"] = 0.2;
  folder.write("swept.json", swept.dump());
  folder.write("grains.json", grains());
  struct Case {
    std::string run;
    int first, second;
  };
  for (const Case& of : {Case{"mixed.json", 3, 2}, Case{"mixed.json --precision float32_compensated", 1, 3},
                         Case{"swept.json", 3, 2}, Case{"grains.json", 3, 2}, Case{"sheet.json --duration 0.2", 3, 2},
                         Case{"sheet.json --duration 0.2 --precision float32_compensated", 1, 2}}) {
    CAPTURE(of.run);
    const std::string arguments = "run " + of.run + " --json --every 3 --threads ";
    auto whole = said(run(folder, arguments + "1 --out whole.csv --events whole-events.csv"));
    if (whole.contains("meet")) whole["meet"].erase("rebuilt");  // a resumed run starts with new lists
    CHECK(folder.read("whole-events.csv").size() > 100);
    const auto check = [&](int ranks, const std::string& more) {
      const auto result = run_on(ranks, folder, arguments + "2 --out a.csv --events e.csv " + more);
      auto report = said(result);
      report.erase("resumed_at_step");
      if (report.contains("meet")) report["meet"].erase("rebuilt");
      CHECK(report == whole);
      CHECK(folder.read("a.csv") == folder.read("whole.csv"));
      CHECK(folder.read("e.csv") == folder.read("whole-events.csv"));
    };
    check(of.first, "--checkpoint at --checkpoint-every 11");
    check(of.second, "--resume at --checkpoint again --checkpoint-every 6");
  }
}

TEST_CASE("ranks: a checkpoint has the bytes of one rank's, and a damaged one is reported once" * doctest::skip(has_no_mpi)) {
  const MixedFolder folder("checkpoint");
  const std::string arguments = "run mixed.json --every 4 --out a.csv --checkpoint at --checkpoint-every 13";
  // The head and the columns only: contacts' sums may have other words for equal values, and the end contains a duration.
  const auto written = [&] {
    const auto bytes = folder.read("at");
    REQUIRE(bytes.size() > 1400);
    return bytes.substr(0, 1400) + folder.read("at.states");
  };
  REQUIRE(run(folder, arguments).exit == 0);
  const auto alone = written();
  std::filesystem::remove(folder / "at");
  const auto result = run_on(3, folder, arguments);
  REQUIRE_MESSAGE(result.exit == 0, result.err);
  CHECK(written() == alone);
  auto bytes = folder.read("at");
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  folder.write("at", bytes);
  const auto refused = run_on(3, folder, "run mixed.json --resume at");
  CHECK(refused.exit == 4);
  CHECK(times(refused.err, "at: is damaged") == 1);
}

TEST_CASE("ranks: a .pvtp has a piece for each rank, and an index that names the pieces" * doctest::skip(has_no_mpi)) {
  const MixedFolder folder("pieces");
  const auto corners = [&](const std::string& file) {
    pugi::xml_document piece;
    REQUIRE(piece.load_file((folder / file).c_str()));
    return piece.child("VTKFile").child("PolyData").child("Piece").attribute("NumberOfPoints").as_int();
  };
  for (const int ranks : {3, 1}) {
    const auto result = run_on(ranks, folder, "run mixed.json --every 10 --out all.pvtp");
    REQUIRE_MESSAGE(result.exit == 0, result.err);
    for (const char* index : {"all.pvtp", "all-000000.pvtp", "all-000001.pvtp", "all-000002.pvtp"}) {
      pugi::xml_document document;
      REQUIRE(document.load_file((folder / index).c_str()));
      const auto data = document.child("VTKFile").child("PPolyData");
      CHECK(std::string(data.child("PPoints").child("PDataArray").attribute("Name").value()) == "position");
      CHECK(std::string(data.child("PPointData").child("PDataArray").attribute("type").value()) == "Float32");
      int particles = 0;
      int pieces = 0;
      for (const auto& piece : data.children("Piece")) {
        ++pieces;
        particles += corners(piece.attribute("Source").value());
      }
      CHECK(pieces == ranks);
      CHECK(particles == 53);
    }
    CHECK(times(folder.read("all.pvd"), ".pvtp") == 3);
    // No pieces of a run with more ranks remain.
    CHECK(std::filesystem::exists(folder / "all-000002-0002.vtp") == (ranks == 3));
  }
}

// A sheet whose springs join all rows, and particles that come and go.
TEST_CASE("ranks: the pieces together hold all particles and faces of a sheet, and all particles that come and go" *
          doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("gathered-pieces");
  folder.write("sheet.json", sheet());
  folder.write("drops.json", drops());
  for (const auto& of : {std::pair(std::string("sheet"), 2 * 7), std::pair(std::string("drops"), 0)}) {
    const std::string& scene = of.first;
    const int ghosts = of.second;
    CAPTURE(scene);
    const auto numbers = [&](const std::string& file, const char* attribute) {
      pugi::xml_document piece;
      REQUIRE(piece.load_file((folder / file).c_str()));
      return piece.child("VTKFile").child("PolyData").child("Piece").attribute(attribute).as_int();
    };
    const auto last = scene + "-000001";
    const std::string command = "run " + scene + ".json --every 100 --out " + scene;
    for (const auto& [ranks, more] : {std::pair(1, ".vtp"), std::pair(3, ".pvtp --checkpoint at --checkpoint-every 3")}) {
      const auto result = run_on(ranks, folder, command + more);
      REQUIRE_MESSAGE(result.exit == 0, result.err);
    }
    int points = 0;
    int faces = 0;
    for (const char* piece : {"-0000.vtp", "-0001.vtp", "-0002.vtp"}) {
      CHECK(numbers(last + piece, "NumberOfPoints") > 7);
      points += numbers(last + piece, "NumberOfPoints");
      faces += numbers(last + piece, "NumberOfPolys");
    }
    CHECK(points == numbers(last + ".vtp", "NumberOfPoints") + ghosts);
    CHECK(faces == numbers(last + ".vtp", "NumberOfPolys"));
    CHECK(times(folder.read(scene + ".pvtp"), "<Piece ") == 3);
    CHECK(times(folder.read(scene + ".pvtp"), "vtkGhostType") == (ghosts > 0 ? 1 : 0));
  }
}

}  // namespace ranks::files_test
