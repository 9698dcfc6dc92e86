// Networks on several ranks: the bits of one rank, and the counts of explain.
#include <doctest/doctest.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <string>
#include <utility>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "dvdx/plan.hpp"
#include "scene_io/scene_reader.hpp"
#include "state/start.hpp"
#include "tools/ranks.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace ranks::network_test {

TEST_CASE("ranks: networks have the bits of one rank" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-networks");
  folder.write("sheet.json", sheet());
  folder.write("list.json", list());
  auto skin = nlohmann::json::parse(sheet());
  skin["skins"] = {{{"particles", {30, 31, 32, 44, 45}}, {"at_most", 0.01}}};
  folder.write("skin.json", skin.dump());
  std::size_t turn = 0;
  for (const char* run_of :
       {"sheet.json", "sheet.json --set network.bend=0 --set network.damping=0.01 --precision float64", "list.json",
        "list.json --scheme fourth_order --precision float32_compensated", "sheet.json --scheme accumulate", "skin.json"}) {
    CAPTURE(run_of);
    const std::string arguments = std::string("run ") + run_of + " --json --threads 1";
    const auto alone = said(run(folder, arguments));
    for (const int ranks : ranks_of(turn++)) {
      CAPTURE(ranks);
      CHECK(said(run_on(ranks, folder, arguments)) == alone);
    }
  }
}

// The sub-steps and the heating are found without a plan of the whole, except where bounds leave them open.
TEST_CASE("ranks: a sheet that no rank plans whole has the bits, the report and the refusals of one rank" *
          doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-rows");
  auto scene = nlohmann::json::parse(sheet());
  scene["network"]["rows"] = 70;
  scene["network"]["edge_v"] = {0, 3, 10};
  scene["duration"] = 0.8;
  scene["particles"] = {{"velocity", {{"uniform", {{"min", {-9, -9, -9}}, {"max", {9, 9, 9}}, {"seed", 3}}}}}};
  folder.write("sheet.json", scene.dump());
  std::size_t turn = 0;
  for (const char* more :
       {"", " --scheme fourth_order --threads 2", " --set network.scheme=sequential --set network.lines=none",
        " --substeps 12 --precision float64", " --precision float32_compensated"}) {
    CAPTURE(more);
    const std::string arguments = std::string("run sheet.json --json") + more;
    const auto alone = said(run(folder, arguments));
    for (const int ranks : ranks_of(turn++)) CHECK(said(run_on(ranks, folder, arguments)) == alone);
  }
  for (const char* more :
       {" --substeps 1 --set network.structural=4000", " --set network.mass=1e-300", " --set particles.velocity=[1e300,0,0]"}) {
    CAPTURE(more);
    const std::string arguments = std::string("run sheet.json --json") + more;
    const auto alone = run(folder, arguments);
    const auto split = run_on(3, folder, arguments);
    CHECK(alone.exit != 0);
    CHECK(split.exit == alone.exit);
    CHECK(split.err.find(alone.err) != std::string::npos);
  }
}

// Nothing in the rows of the first rank can move, so by these alone it would take one sub-step. Ranks that take different ones
// may wait for each other without end, hence a run without steps comes first.
TEST_CASE("ranks: a sheet whose last rows alone can move takes their sub-steps on every rank" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-held-rows");
  auto scene = nlohmann::json::parse(sheet());
  scene["network"]["fixed"] = nlohmann::json::array();
  for (int i = 0; i < 7 * 7; ++i) scene["network"]["fixed"].push_back(i);
  folder.write("sheet.json", scene.dump());
  for (const char* duration : {"0", "0.05"}) {
    const std::string arguments = std::string("run sheet.json --json --threads 1 --duration ") + duration;
    const auto alone = said(run(folder, arguments));
    CHECK(alone["substeps"] > 1);
    REQUIRE(said(run_on(2, folder, arguments)) == alone);
  }
}

// The owners search for springs that tear. The number of sub-steps may then fall for all ranks.
TEST_CASE("ranks: a network that tears has the bits and files of one rank, also when resumed" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-torn");
  folder.write("playback.html", "<!-- dvdx data -->");
  const std::string viewer = "DVDX_VIEWER=.";
  auto scene = nlohmann::json::parse(sheet());
  scene["network"]["tears_at"] = 1.02;
  scene["network"]["structural"] = 20;
  scene["duration"] = 0.4;
  folder.write("sheet.json", scene.dump());
  scene["network"]["scheme"] = "sequential";
  scene["network"]["lines"] = "none";
  scene["network"]["rows"] = 100;
  scene["network"]["edge_v"] = {0, 3, 10};
  scene["network"]["tears_at"] = 1.03;
  folder.write("swept.json", scene.dump());
  auto springs = nlohmann::json::parse(list());
  springs["network"][0]["tears_at"] = 1.2;
  springs["network"][1]["tears_at"] = 1.01;
  springs["duration"] = 0.4;
  folder.write("list.json", springs.dump());
  for (const auto& of : {std::pair("sheet.json", 2), std::pair("sheet.json --precision float64", 5), std::pair("swept.json", 2),
                         std::pair("list.json --scheme fourth_order", 3)}) {
    const char* const run_of = of.first;
    const int ranks = of.second;
    CAPTURE(run_of);
    const std::string arguments = std::string("run ") + run_of + " --json --every 7 --threads 1 --out ";
    const auto alone = said(run(folder, arguments + "whole.html", viewer));
    CHECK(alone["torn"] > 5);
    for (const char* more : {" --checkpoint at --checkpoint-every 13", " --resume at"}) {
      auto report = said(run(folder, arguments + "a.html" + more, launcher(ranks, viewer)));
      report.erase("resumed_at_step");
      CHECK(report == alone);
      CHECK(folder.read("a.html") == folder.read("whole.html"));
    }
  }
}

TEST_CASE("ranks: a run sends as many bytes and messages as explain predicts" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-told");
  folder.write("sheet.json", sheet());
  folder.write("list.json", list());
  for (const char* scene : {"sheet.json", "sheet.json --set network.damping=0.01 --precision float64", "list.json",
                            "sheet.json --set network.scheme=accumulate", "list.json --scheme accumulate"}) {
    CAPTURE(scene);
    const auto result = run_on(3, folder, std::string("run ") + scene + " --json --threads 1");
    REQUIRE_MESSAGE(result.exit == 0, result.err);
    const auto report = nlohmann::json::parse(result.out);
    const auto [bytes, messages] = predicted(folder, scene, 3);
    const auto substeps = report["steps"].get<std::uint64_t>() * report["substeps"].get<std::uint64_t>();
    CHECK(messages > 0);
    CHECK(report["halo"]["bytes"] == substeps * bytes);
    CHECK(report["halo"]["messages"] == substeps * messages);
  }
}

// A band of a sheet 7 wide has 32 rows, and a rank has two bands, so some of these ranks have no rows.
TEST_CASE("ranks: networks that are swept have the bits of one rank, and send what explain predicts" *
          doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-swept");
  auto scene = nlohmann::json::parse(sheet());
  scene["network"]["rows"] = 150;
  scene["network"]["edge_v"] = {0, 3, 10};
  scene["network"]["scheme"] = "sequential";
  scene["network"]["lines"] = "none";
  scene["network"]["substeps"] = 3;
  scene["duration"] = 0.2;
  folder.write("sheet.json", scene.dump());
  scene["network"]["bend"] = 0;
  scene["network"]["aerodynamics"] = {{"density", 1.2}, {"drag", 1.0}, {"lift", 0.5}};
  folder.write("flag.json", scene.dump());
  auto list = nlohmann::json::parse(sheet());
  list["network"]["rows"] = list["network"]["columns"] = 70;  // two pieces
  list["network"]["scheme"] = "sequential";
  list["network"]["lines"] = "none";
  list["network"]["substeps"] = 2;
  nlohmann::json more{{"type", "springs"}, {"pairs", {{0, 4000}, {3, 9}}}, {"stiffness", 5}, {"rest_length", "start"}};
  more["scheme"] = "sequential";
  more["lines"] = "none";
  more["substeps"] = 2;
  list["network"] = {list["network"], more};
  folder.write("list.json", list.dump());
  auto in_rows = list;  // two networks that sweeps walk as one sheet
  in_rows["network"][0]["rows"] = 150;
  in_rows["network"][0]["columns"] = 20;
  in_rows["network"][0]["shear"] = in_rows["network"][0]["bend"] = 0;
  in_rows["network"][1]["pairs"] = {{0, 21}, {22, 43}, {1203, 1222}, {2959, 2978}};
  folder.write("in_rows.json", in_rows.dump());
  auto three = nlohmann::json::parse(sheet());
  three["network"]["scheme"] = "sequential";
  three["network"]["lines"] = "none";
  three["network"] = {three["network"], three["network"], three["network"]};
  folder.write("three.json", three.dump());
  std::size_t turn = 0;
  for (const char* run_of : {"three.json", "sheet.json --set network.damping=0.01 --precision float64",
                             "sheet.json --set network.theta=0.6 --precision float32_compensated",
                             "list.json --precision float32_compensated", "flag.json"}) {
    CAPTURE(run_of);
    const std::string arguments = std::string("run ") + run_of + " --json --threads 1";
    const auto alone = said(run(folder, arguments));
    for (const int ranks : ranks_of(turn++)) {
      CAPTURE(ranks);
      CHECK(said(run_on(ranks, folder, arguments)) == alone);
    }
  }
  for (const std::string name : {"sheet.json", "list.json", "in_rows.json"}) {
    const std::string arguments = "run " + name + " --json --threads 1";
    const auto alone = said(run(folder, arguments));
    for (const int ranks : {2, 5}) {
      CAPTURE(name);
      CAPTURE(ranks);
      const auto result = run_on(ranks, folder, arguments);
      CHECK(said(result) == alone);
      const auto report = nlohmann::json::parse(result.out);
      const auto [bytes, messages] = predicted(folder, name, ranks);
      const auto substeps = report["steps"].get<std::uint64_t>() * report["substeps"].get<std::uint64_t>();
      if (name != "list.json") CHECK(messages == (ranks == 2 ? 2 : name == "sheet.json" ? 4 : 6));
      CHECK(messages > 0);
      CHECK(report["halo"]["bytes"] == substeps * bytes);
      CHECK(report["halo"]["messages"] == substeps * messages);
    }
  }
}

TEST_CASE("ranks: cloth in wind has the bits of one rank, as a sheet and as a list" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-air");
  auto scene = nlohmann::json::parse(sheet());
  scene["network"]["bend"] = 0;
  scene["network"]["aerodynamics"] = {{"density", 1.2}, {"drag", 1.0}, {"lift", 0.5}};
  scene["wind"] = {{"mean", {9, 1, 3}}, {"gusts", {{{"amplitude", {2, 0, 5}}, {"angular_frequency", 40}}}}};
  folder.write("sheet.json", scene.dump());
  scene["network"]["damping"] = 0.01;
  const nlohmann::json one_more{{"type", "springs"}, {"pairs", {{0, 10}}}, {"stiffness", 5}, {"rest_length", "start"}};
  scene["network"] = {scene["network"], one_more};  // with it the sheet is stepped as a list
  folder.write("list.json", scene.dump());
  for (const char* run_of : {"sheet.json", "list.json --scheme fourth_order --precision float64"}) {
    CAPTURE(run_of);
    const std::string arguments = std::string("run ") + run_of + " --json --threads 1";
    const auto alone = said(run(folder, arguments));
    for (const int ranks : {2, 5}) {
      CAPTURE(ranks);
      CHECK(said(run_on(ranks, folder, arguments)) == alone);
    }
  }
}

// The command finds them without a plan of the sheet. A plan examines its springs, and turning motions.
TEST_CASE("a run that plans a sheet by rows finds the sub-steps of the sheet's plan") {
  const ScratchFolder folder("sheet-substeps");
  auto scene = nlohmann::json::parse(sheet());
  scene["motions"]["spin"]["keys"] = {{{"time", 0}}, {{"time", 0.01}, {"rotation", {0, 3, 0}}}};
  std::vector<int> found;
  for (const bool turns : {false, true}) {
    if (turns) scene["contacts"][0]["motion"] = "spin";
    for (const char* scheme : {"leapfrog", "fourth_order", "sequential"}) {
      CAPTURE(turns);
      CAPTURE(scheme);
      scene["network"]["scheme"] = scheme;
      const std::string text = scene.dump();
      folder.write("sheet.json", text);
      const auto file = dvdx::tool::parse_scene("sheet.json", text);
      dvdx::Soa<float> memory(file.particles.count);
      auto state = memory.view();
      dvdx::tool::place_at_start(file, state);
      const auto plan = dvdx::compile<float>(file.scene, {.step = file.step}, state);
      REQUIRE_MESSAGE(plan.has_value(), (plan ? "" : plan.error().message()));
      found.push_back(plan->network_limit()->substeps);
      CHECK(said(run(folder, "run sheet.json --json"))["substeps"] == found.back());
    }
  }
  CHECK(found[0] > 1);
  CHECK(found[5] > found[2]);
}

// Two strips of squares whose common side occurs twice in the file, after a vertex without a face.
TEST_CASE("ranks: a welded mesh is written by its file's vertices, as one rank writes it" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("welded");
  std::string mesh = "v 9 9 9\n";
  std::string faces;
  for (int strip = 0; strip < 2; ++strip) {
    const int first = 2 + 40 * strip;
    for (int n = 0; n < 20; ++n) {
      for (int side = 0; side < 2; ++side) mesh += "v " + std::to_string(n) + " 0 " + std::to_string(strip + side) + "\n";
      const int at = first + 2 * n;
      if (n > 0)
        faces += "f " + std::to_string(at - 2) + " " + std::to_string(at) + " " + std::to_string(at + 1) + " " +
                 std::to_string(at - 1) + "\n";
    }
  }
  folder.write("strips.obj", mesh + faces);
  folder.write("strips.json", R"({"format": "dvdx-scene/1", "name": "strips", "step": 0.01, "duration": 0.2,
    "network": {"type": "mesh", "file": "strips.obj", "mass": 6, "edge": 100, "bend": 1, "fixed": [1, 2, 42]},
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}]})");
  const auto one = run(folder, "run strips.json --every 10 --out one.csv --json");
  REQUIRE_MESSAGE(one.exit == 0, one.err);
  CHECK(nlohmann::json::parse(one.out)["particles"] == 60);
  for (const char* more : {"three.csv", "three.pvtp"}) {
    const auto three = run_on(3, folder, std::string("run strips.json --every 10 --json --out ") + more);
    REQUIRE_MESSAGE(three.exit == 0, three.err);
    CHECK(nlohmann::json::parse(three.out)["state_hash"] == nlohmann::json::parse(one.out)["state_hash"]);
  }
  CHECK(folder.read("three.csv") == folder.read("one.csv"));
  pugi::xml_document piece;
  REQUIRE(piece.load_file((folder / "three-000002-0000.vtp").c_str()));
  CHECK(piece.child("VTKFile").child("PolyData").child("Piece").attribute("NumberOfPoints").as_int() == 81);
}

}  // namespace ranks::network_test
