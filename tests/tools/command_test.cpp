// The command as a user runs it: exit codes, what goes to stdout and what to stderr, and what is written.
#include <doctest/doctest.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "support/close.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace command_test {

using dvdx::test::is_close;
using dvdx::test::run;
using dvdx::test::ScratchFolder;
using nlohmann::json;
using namespace std::string_literals;

constexpr const char* fall = R"({
  "format": "dvdx-scene/1", "name": "fall", "step": 0.125, "duration": 1.25,
  "particles": {"count": 20, "position": {"uniform": {"min": [0, 1, 0], "max": [1, 9, 1], "seed": 3}}},
  "forces": [{"type": "constant", "acceleration": [0, -8, 0]},
             {"type": "spring", "stiffness": 2, "anchor": "start", "method": "symplectic_euler"}],
  "fixed": [7]
})";

class Folder : public ScratchFolder {
 public:
  explicit Folder(const std::string& name) : ScratchFolder("command-" + name) { write("fall.json", fall); }
};

TEST_CASE("run prints a table on stdout and nothing on stderr") {
  const Folder folder("table");
  const auto result = run(folder, "run fall.json");
  CHECK(result.exit == 0);
  CHECK(result.out.find("fall, 20 particles") != std::string::npos);
  CHECK(result.out.find("10 of 0.125 s") != std::string::npos);
  CHECK(result.err.empty());
}

TEST_CASE("run --json prints one object with exactly the contract's keys") {
  const Folder folder("json");
  const auto result = run(folder, "run fall.json --json --precision float64 --isa reference --layout aos --threads 1");
  REQUIRE(result.exit == 0);
  const auto report = json::parse(result.out);
  std::vector<std::string> keys;
  for (const auto& item : report.items()) keys.push_back(item.key());
  CHECK(keys == std::vector<std::string>{"arithmetic", "bad_particles", "contacts", "diverged", "energy", "isa", "layout",
                                         "method", "particle_steps_per_second", "particles", "precision", "scene", "scheme",
                                         "state_hash", "steps", "substeps", "threads", "wall_seconds"});
  CHECK(report["scene"] == "fall");
  CHECK(report["particles"] == 20);
  CHECK(report["steps"] == 10);
  CHECK(report["method"] == "combined");
  CHECK(report["scheme"].is_null());
  CHECK(report["substeps"] == 1);
  CHECK(report["precision"] == "float64");
  CHECK(report["isa"] == "reference");
  CHECK(report["threads"] == 1);
  CHECK(report["layout"] == "aos");
  CHECK(report["arithmetic"] == "separate");
  CHECK(report["state_hash"].get<std::string>().size() == 16);
  CHECK(report["energy"].size() == 2);
  CHECK(report["energy"]["start"].is_number());
  CHECK(report["diverged"] == false);
  CHECK(report["bad_particles"] == 0);
}

TEST_CASE("run warns of meshes that fall apart, with a code and a cure, and --strict ends with exit code 6") {
  const Folder folder("warned");
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  folder.write("whole.obj", square + "f 1 2 3\nf 1 3 4\n");
  folder.write("seam.obj", square + "v 0 0 0\nv 1 1 0\nf 1 2 3\nf 5 6 4\n");
  folder.write("loose.obj", square + "v 9 9 9\nf 1 2 3\nf 1 3 4\n");
  folder.write("points.obj", square);
  folder.write("cloth.json", R"({"format": "dvdx-scene/1", "name": "cloth", "step": 0.01, "duration": 0.05,
    "network": {"type": "mesh", "file": "whole.obj", "mass": 1, "edge": 10}})");
  const auto warned = [&](const std::string& file, const std::string& code, double value, double limit) {
    CAPTURE(file);
    const auto result = run(folder, "run cloth.json --json --set network.file=" + file);
    CHECK(result.exit == 0);
    const auto warnings = json::parse(result.out)["warnings"];
    REQUIRE(warnings.size() == 1);
    CHECK(warnings[0]["code"] == code);
    CHECK(warnings[0]["value"] == value);
    CHECK(warnings[0]["limit"] == limit);
    const auto said = warnings[0]["text"].get<std::string>() + ". " + warnings[0]["cure"].get<std::string>();
    CHECK(result.err.find("cloth.json: warning: " + code + ": " + said) != std::string::npos);
    CHECK(run(folder, "run cloth.json --strict --set network.file=" + file).exit == 6);
    CHECK(run(folder, "explain cloth.json --set network.file=" + file).err.find("warning: " + code) != std::string::npos);
  };
  warned("seam.obj --set network.weld=null", "pieces", 2, 1);
  warned("loose.obj", "unreferenced_vertices", 1, 0);
  warned("points.obj", "no_faces", 4, 0);
  const auto calm = run(folder, "run cloth.json --json --strict");
  CHECK(calm.exit == 0);
  CHECK(calm.err.empty());
  CHECK(json::parse(calm.out)["warnings"] == json::array());
}

std::string hash_of(const ScratchFolder& folder, const std::string& options) {
  const auto result = run(folder, "run fall.json --json " + options);
  CAPTURE(options);
  CAPTURE(result.err);
  REQUIRE(result.exit == 0);
  return json::parse(result.out)["state_hash"];
}

TEST_CASE("the state does not depend on layout, threads or instruction set, but on the method") {
  const Folder folder("hash");
  const auto hash = hash_of(folder, "");
  for (const char* options : {"--layout aos", "--layout aosoa", "--threads 1", "--isa reference", "--every 3 --out a.csv"}) {
    CHECK(hash_of(folder, options) == hash);
  }
  CHECK(hash_of(folder, "--precision float64") != hash);
  const auto all_euler = hash_of(folder, "--method symplectic_euler");
  CHECK(all_euler != hash);
  // --method replaces each force's own as well.
  CHECK(hash_of(folder, "--method exact") == hash_of(folder, "--set forces[0].method=exact --set forces[1].method=exact"));
}

TEST_CASE("states are written at step 0, every N steps and at the end") {
  const Folder folder("every");
  const auto steps_written = [&](const std::string& options) {
    REQUIRE(run(folder, "run fall.json --out a.csv " + options).exit == 0);
    std::vector<std::string> steps;
    std::istringstream rows(folder.read("a.csv"));
    for (std::string row; std::getline(rows, row);) {
      const auto step = row.substr(0, row.find(','));
      if (step != "step" && (steps.empty() || steps.back() != step)) steps.push_back(step);
    }
    return steps;
  };
  using Steps = std::vector<std::string>;
  CHECK(steps_written("") == Steps{"10"});
  CHECK(steps_written("--every 0") == Steps{"10"});
  CHECK(steps_written("--every 4") == Steps{"0", "4", "8", "10"});
  CHECK(steps_written("--every 5") == Steps{"0", "5", "10"});
  CHECK(steps_written("--every 100") == Steps{"0", "10"});
  CHECK(steps_written("--every 1 --duration 0") == Steps{"0"});
  CHECK(steps_written("--fps 2") == Steps{"0", "4", "8", "10"});  // of 8 steps a second
  CHECK(steps_written("--fps 3") == Steps{"0", "3", "5", "8", "10"});
  CHECK(steps_written("--fps 1000 --duration 0.25") == Steps{"0", "1", "2"});
}

TEST_CASE("a run says what it wrote: what is played has 30 states a second, all else the last one") {
  const Folder folder("written");
  const auto written = [&](const std::string& options) {
    const auto result = run(folder, "run fall.json --step 0.0078125 " + options);  // 160 steps of 1/128 s
    REQUIRE(result.exit == 0);
    const auto at = result.out.find("written      ");
    return at == std::string::npos ? "nothing" : result.out.substr(at + 13, result.out.find('\n', at) - at - 13);
  };
  CHECK(written("") == "nothing");
  CHECK(written("--out a.csv") == "a.csv (the last state)");
  CHECK(written("--out a.csv --events e.csv") == "a.csv (the last state), e.csv");
  CHECK(written("--out a.npz") == "a.npz (39 frames)");  // 0, 1/30, ..., 37/30 and 1.25 s
  CHECK(written("--out a.npz --every 0") == "a.npz (the last state)");
  CHECK(written("--out a.pc2") == "a.pc2 (39 frames), a.obj");
  CHECK(written("--out a.ply --every 80") == "a-000000.ply to a-000002.ply (3 frames)");
  CHECK(written("--out a.vtp --fps 1") == "a-000000.vtp to a-000002.vtp (3 frames), a.pvd");
  CHECK(written("--out b.obj") == "b.obj (the last state)");
  CHECK(written("--out b.obj --every 160") == "b-000000.obj to b-000001.obj (2 frames)");
  CHECK(written("--out b.png") == "b.png (the last state)");
  CHECK(written("--out b.apng --fps 4") == "b.apng (6 frames)");
  for (const char* file : {"a.csv", "e.csv", "a.npz", "a.pc2", "a.obj", "a-000002.ply", "a-000002.vtp", "a.pvd", "b.obj",
                           "b-000001.obj", "b.png", "b.apng"}) {
    CAPTURE(file);
    CHECK_FALSE(folder.read(file).empty());
  }
  const auto report = json::parse(run(folder, "run fall.json --json --out a.pc2 --every 5").out);
  CHECK(report["written"] == json::parse(R"([{"file": "a.pc2", "frames": 3}, {"file": "a.obj"}])"));
}

TEST_CASE("an .obj is the last state, with the faces of its sheets") {
  const ScratchFolder folder("command-obj");
  folder.write("square.json", R"({"format": "dvdx-scene/1", "name": "square", "step": 0.5, "duration": 1,
    "network": {"type": "grid", "rows": 2, "columns": 2, "origin": [0, 1, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0, 1],
                "mass": 1, "structural": 1}, "forces": [{"type": "constant", "acceleration": [0, -2, 0]}]})");
  REQUIRE(run(folder, "run square.json --out a.obj --precision float64").exit == 0);
  const auto text = folder.read("a.obj");
  CHECK(text.starts_with("# dvdx: step 2, 1 s\nv 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 1\nf "));  // 1 - 2 t^2 / 2
  CHECK(run(folder, "run square.json --set network.type=mesh --set network.file=a.obj --out a.obj").exit != 0);
  CHECK(folder.read("a.obj") == text);
}

TEST_CASE("every format is written whole") {
  const Folder folder("formats");
  CHECK(run(folder, "run fall.json --every 5 --out a.npz").exit == 0);
  CHECK(run(folder, "run fall.json --every 5 --out b.ply --precision float64").exit == 0);
  CHECK(run(folder, "run fall.json --every 5 --out c.vtp").exit == 0);
  CHECK(run(folder, "run fall.json --every 5 --out d.pc2").exit == 0);
  CHECK(folder.entries() == 1 + 1 + 3 + 4 + 2);
}

TEST_CASE("a negative step runs time backwards") {
  const Folder folder("backwards");
  const auto result = run(folder, "run fall.json --step -0.25 --out a.csv");
  CHECK(result.exit == 0);
  CHECK(folder.read("a.csv").find("\n5,-1.25,0,") != std::string::npos);
}

TEST_CASE("a word that is no command is named, with those that there are") {
  const auto result = run(Folder("walk"), "walk fall.json");
  CHECK(result.exit == 2);
  CHECK(result.err ==
        "dvdx: walk is not a command: known are new, run, report, tune, explain, verify, stability, merge, info, help\n");
}

TEST_CASE("usage is exit 2, with a message on stderr alone") {
  const Folder folder("usage");
  for (const char* arguments : {"",
                                "walk fall.json",
                                "run",
                                "run fall.json --speed 3",
                                "run fall.json --precision float16",
                                "run fall.json --isa mmx",
                                "run fall.json --layout rows",
                                "run fall.json --method verlet",
                                "run fall.json --threads 0",
                                "run fall.json --every -1",
                                "run fall.json --fps 0",
                                "run fall.json --fps inf",
                                "run fall.json --fps 30 --every 2",
                                "help walk",
                                "new cloth",
                                "new snow a.json",
                                "run fall.json --step 0",
                                "run fall.json --step nan",
                                "run fall.json --step 0.3",
                                "run fall.json --duration -1",
                                "run fall.json --out a.xyz",
                                "run fall.json --set stiffness",
                                "run fall.json --scheme leapfrog",
                                "run fall.json --substeps 4",
                                "run fall.json --isa sse2 --arithmetic contracted",
                                "run fall.json --step 1e9",
                                "run fall.json --every 0x10",
                                "run fall.json --threads 010",
                                "run fall.json --seed -1",
                                "run fall.json --seed +1",
                                "run fall.json --seed 18446744073709551616",
                                "run fall.json --checkpoint a --checkpoint-every 0",
                                "run fall.json --step ''",
                                "run fall.json --every ''",
                                "run fall.json --out ''",
                                "run fall.json --resume ''",
                                "run fall.json --substeps ''",
                                "run ''",
                                "stability --cases 03",
                                "tune fall.json --error 0",
                                "tune fall.json --error inf",
                                "explain fall.json --ranks 1e3",
                                "explain fall.json --ranks 2 --latency -1"}) {
    CAPTURE(std::string(arguments));
    const auto result = run(folder, arguments);
    CHECK(result.exit == 2);
    CHECK(result.out.empty());
    CHECK_FALSE(result.err.empty());
  }
  CHECK(run(folder, "run fall.json --isa mmx").err.find("there are best, reference") != std::string::npos);
  CHECK(run(folder, "run fall.json", "DVDX_ISA=mmx").exit == 2);
  CHECK(run(folder, "run fall.json", "DVDX_ISA=reference").exit == 0);
  for (const char* const command : {"info", "info --json", "explain fall.json", "stability --cases 3"}) {
    const auto result = run(folder, command, "DVDX_ISA=mmx");
    CHECK(result.exit == 2);
    CHECK(result.out.empty());
    CHECK(result.err.starts_with("dvdx: DVDX_ISA mmx: no such instruction set: with separate arithmetic there are best, ref"));
  }
  CHECK(folder.entries() == 1);
}

TEST_CASE("a number that an option cannot take is named with what it can") {
  const Folder folder("numbers");
  CHECK(run(folder, "run fall.json --seed -1")
            .err.starts_with("--seed: -1: must be a whole number from 0 to 18446744073709551615\n"));
  CHECK(run(folder, "run fall.json --threads 010").err.starts_with("--threads: 010: must be a whole number from 1 to 1024\n"));
  CHECK(run(folder, "tune fall.json --error x").err.starts_with("--error: x: must be a finite number > 0\n"));
  CHECK(run(folder, "run fall.json --every ''").err.starts_with("--every: nothing: must be a whole number from 0 to "));
  CHECK(run(folder, "run fall.json --resume ''").err.starts_with("--resume: must not be empty\n"));
  CHECK(run(folder, "run fall.json --seed 18446744073709551615").exit == 0);
}

TEST_CASE("the files that a run writes and the one that it goes on from differ") {
  const Folder folder("same-file");
  REQUIRE(run(folder, "run fall.json --checkpoint c.csv --checkpoint-every 3").exit == 0);
  const auto checkpoint = folder.read("c.csv");
  const std::string same = folder.path().string();
  for (const std::string& arguments :
       {"--out a.csv --events ./a.csv"s, "--out a.csv --checkpoint '" + same + "/a.csv' --checkpoint-every 3",
        "--out c.csv --resume ./c.csv"s, "--events c.csv --resume c.csv"s,
        "--events a.csv --checkpoint a.csv --checkpoint-every 3"s}) {
    CAPTURE(arguments);
    const auto result = run(folder, "run fall.json " + arguments);
    CHECK(result.exit == 2);
    CHECK(result.err.find(": must be another file than that of --") != std::string::npos);
  }
  CHECK(folder.entries() == 2);
  CHECK(folder.read("c.csv") == checkpoint);
}

TEST_CASE("a bad scene is exit 3, named, and nothing is written") {
  const Folder folder("bad-scene");
  const auto result = run(folder, "run fall.json --set forces[1].stiffness=-3 --out a.csv");
  CHECK(result.exit == 3);
  CHECK(result.out.empty());
  CHECK(result.err == "dvdx: fall.json: forces[1].stiffness is -3: must be a finite number >= 0\n");
  CHECK(run(folder, "run fall.json --set particles.count=1000000000000000").exit == 3);
  CHECK(run(folder, "explain fall.json --set particles.mass=0").exit == 3);
  CHECK(folder.entries() == 1);
}

TEST_CASE("a file that cannot be read or written is exit 4, and nothing is written") {
  const Folder folder("files");
  for (const char* arguments : {"run none.json", "run .", "run fall.json --out none/a.csv", "explain none.json"}) {
    CAPTURE(std::string(arguments));
    const auto result = run(folder, arguments);
    CHECK(result.exit == 4);
    CHECK(result.out.empty());
    CHECK(result.err.starts_with("dvdx: "));
  }
  CHECK(folder.entries() == 1);
}

TEST_CASE("a simulation that diverges is exit 5, and says so in its output") {
  const Folder folder("diverged");
  const std::string unstable = "run fall.json --method symplectic_euler --set forces[1].stiffness=1e6 --duration 125 --json";
  const auto result = run(folder, unstable + " --out a.csv");
  CHECK(result.exit == 5);
  CHECK(result.err.find("diverged") != std::string::npos);
  const auto report = json::parse(result.out);
  CHECK(report["diverged"] == true);
  CHECK(report["bad_particles"] == 19);  // all but the fixed one
  CHECK(report["energy"]["end"].is_null());
  CHECK(report["warnings"].back()["cure"] == "Try --method combined");
  CHECK(run(folder, "run fall.json --method combined --set forces[1].stiffness=1e6 --duration 125").exit == 0);
  CHECK(result.err == "dvdx: fall.json: the simulation diverged: 19 of 20 particles are not finite\n");
  const auto table = run(folder, unstable.substr(0, unstable.find(" --json")));
  CHECK(table.out.find(" at the start, not finite at the end") != std::string::npos);
  CHECK_FALSE(folder.read("a.csv").empty());
}

TEST_CASE("explain and info tell what they are asked") {
  const Folder folder("told");
  const auto explained = run(folder, "explain fall.json");
  CHECK(explained.exit == 0);
  CHECK(explained.out.find("20, 1 of them fixed") != std::string::npos);
  CHECK(run(folder, "info").exit == 0);
  const auto info = json::parse(run(folder, "info --json").out);
  CHECK(info["isas"]["separate"]["machine"][0] == "reference");
  CHECK(info["isas"]["fast"] == info["isas"]["contracted"]);
  CHECK(info["threads"].get<int>() >= 1);
  const auto forced = json::parse(run(folder, "info --json", "DVDX_ISA=reference").out);
  CHECK(forced["isas"]["separate"]["chosen"] == "reference");
  CHECK(run(folder, "info", "DVDX_ISA=reference").out.find("chosen: reference (by DVDX_ISA)") != std::string::npos);
#if defined(__x86_64__)  // where there is a set that fuses nothing
  CHECK(json::parse(run(folder, "info --json", "DVDX_ISA=sse2").out)["isas"]["contracted"]["chosen"].is_null());
  CHECK(run(folder, "info", "DVDX_ISA=sse2").out.find("chosen: none: DVDX_ISA asks for sse2") != std::string::npos);
#endif
  CHECK_FALSE(info["version"].get<std::string>().empty());
}

constexpr const char* sheet = R"({
  "format": "dvdx-scene/1", "name": "sheet", "step": 0.03125, "duration": 0.5,
  "network": {"type": "grid", "rows": 5, "columns": 6, "origin": [0, 1, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0, 0.8],
              "mass": 0.3, "structural": 40, "shear": 10, "bend": 1, "damping": 0.01, "fixed": "corners_top"},
  "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}]
})";

class SheetFolder : public ScratchFolder {
 public:
  explicit SheetFolder(const std::string& name) : ScratchFolder("command-" + name) { write("sheet.json", sheet); }
};

TEST_CASE("run steps networks by the scheme and the sub-steps that are asked for, and says which") {
  const SheetFolder folder("sheet");
  const auto report_of = [&](const std::string& options) {
    const auto result = run(folder, "run sheet.json --json " + options);
    CAPTURE(result.err);
    REQUIRE(result.exit == 0);
    return json::parse(result.out);
  };
  const auto own = report_of("");
  CHECK(own["particles"] == 30);
  CHECK(own["scheme"] == "leapfrog");
  CHECK(own["substeps"].get<int>() > 1);
  CHECK(own["diverged"] == false);
  CHECK(report_of("--substeps auto")["state_hash"] == own["state_hash"]);
  CHECK(report_of("--layout aos --threads 1 --isa reference")["state_hash"] == own["state_hash"]);
  const auto fast = report_of("--arithmetic fast");
  CHECK(fast["arithmetic"] == "fast");
  CHECK(report_of("--arithmetic fast --layout aos --threads 1")["state_hash"] == fast["state_hash"]);
  CHECK(is_close(fast["energy"]["end"].get<double>(), own["energy"]["end"].get<double>(), 1e-3));
  const auto sequential = report_of("--scheme sequential");
  CHECK(sequential["scheme"] == "sequential");
  const auto& estimate = sequential["sweep_estimate"];
  CHECK(estimate["rest"].get<double>() <= 0.01 * estimate["side"].get<double>());
  CHECK(report_of("--scheme sequential --substeps 1")["sweep_estimate"]["rest"].get<double>() >=
        estimate["rest"].get<double>());
  CHECK_FALSE(own.contains("sweep_estimate"));
  CHECK_FALSE(own.contains("scheme_choice"));
  const auto open = report_of("--scheme auto");
  const auto& choice = open["scheme_choice"];
  const bool sweeps = choice["sequential"]["ns_per_step"].get<double>() < choice["leapfrog"]["ns_per_step"].get<double>();
  CHECK(open["scheme"] == (sweeps ? "sequential" : "leapfrog"));
  CHECK(open["state_hash"] == (sweeps ? sequential : own)["state_hash"]);
  CHECK(report_of("--scheme sequential --substeps 3")["substeps"] == 3);
  const auto pulses = report_of("--scheme accumulate --method pulse --substeps 50");
  CHECK(pulses["method"] == "pulse");
  CHECK(pulses["state_hash"] != report_of("--scheme accumulate --method exact --substeps 50")["state_hash"]);
}

TEST_CASE("run and explain refuse sub-steps that are none, too many or too few") {
  const SheetFolder folder("substeps");
  for (const char* substeps : {"0", "-1", "1000001", "2.5", "some", "3x"}) {
    CAPTURE(std::string(substeps));
    CHECK(run(folder, std::string("run sheet.json --substeps=") + substeps).exit == 2);
  }
  const auto unstable = run(folder, "run sheet.json --set network.structural=4e4 --substeps 1");
  CHECK(unstable.exit == 3);
  CHECK(unstable.err.starts_with("dvdx: sheet.json: network.substeps is 1: must be at least "));
  CHECK(run(folder, "explain sheet.json").exit == 0);
  CHECK(run(folder, "explain sheet.json --set network.structural=4e4 --substeps 1").exit == 3);
}

TEST_CASE("a grid's faces stand in the .obj beside its .pc2") {
  const SheetFolder folder("sheet-out");
  CHECK(run(folder, "run sheet.json --out sheet.pc2").exit == 0);
  CHECK(folder.read("sheet.obj").find("\nf 1 2 8 7\n") != std::string::npos);
}

TEST_CASE("where a sheet tears, the files of later states have fewer faces") {
  const ScratchFolder folder("command-tear");
  folder.write("tear.json", R"({"format": "dvdx-scene/1", "name": "tear", "step": 0.005, "duration": 0.5,
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
    "network": {"type": "grid", "rows": 6, "columns": 6, "origin": [0, 0, 0], "edge_u": [1, 0, 0], "edge_v": [0, -1, 0],
                "mass": 0.036, "structural": 20, "fixed": ["edge_top"], "tears_at": 1.02}})");
  const auto result = run(folder, "run tear.json --json --out sheet.vtp --every 50");
  REQUIRE(result.exit == 0);
  CHECK(json::parse(result.out)["torn"] == 6);  // a row of them
  CHECK(folder.read("sheet-000000.vtp").find("NumberOfPolys=\"25\"") != std::string::npos);
  CHECK(folder.read("sheet-000002.vtp").find("NumberOfPolys=\"20\"") != std::string::npos);
  CHECK(run(folder, "run tear.json --out sheet.ply --every 50").exit == 0);
  CHECK(folder.read("sheet-000000.ply").find("element face 25\n") != std::string::npos);
  CHECK(folder.read("sheet-000002.ply").find("element face 20\n") != std::string::npos);

  // They go with the first state whose springs are too long: 0.204 m, of the first row to the second.
  CHECK(run(folder, "run tear.json --out each.vtp --every 1").exit == 0);
  CHECK(run(folder, "run tear.json --out each.csv --every 1").exit == 0);
  std::istringstream lines(folder.read("each.csv"));
  std::string line;
  int torn_at = -1;
  while (torn_at < 0 && std::getline(lines, line)) {
    int step = 0, particle = 0;
    double y = 0;
    const bool is_state = std::sscanf(line.c_str(), "%d,%*f,%d,%*f,%lf", &step, &particle, &y) == 3;
    if (is_state && particle == 6 && y < -0.204) torn_at = step;
  }
  REQUIRE(torn_at > 0);
  const auto faces_of = [&](int step) {
    const std::string number = std::to_string(step);
    const std::string text = folder.read("each-" + std::string(6 - number.size(), '0') + number + ".vtp");
    return text.substr(text.find("NumberOfPolys"), 18);
  };
  CHECK(faces_of(torn_at - 1) == "NumberOfPolys=\"25\"");
  CHECK(faces_of(torn_at) == "NumberOfPolys=\"20\"");
}

TEST_CASE("a mesh that grains fall on: run, explain and verify take it, and what is no body is exit 3") {
  const ScratchFolder folder("mesh-contact");
  const std::string corners = "v -1 -1 -1\nv 1 -1 -1\nv 1 -1 1\nv -1 -1 1\nv 0 0 0\n";
  folder.write("roof.obj", corners + "f 1 2 3 4\nf 1 5 2\nf 2 5 3\nf 3 5 4\nf 4 5 1\n");
  folder.write("open.obj", corners + "f 1 5 2\nf 2 5 3\nf 3 5 4\nf 4 5 1\n");
  folder.write("scene.json", R"({"format": "dvdx-scene/1", "name": "roof", "step": 0.01, "duration": 0.6,
    "particles": {"count": 100, "position": {"uniform": {"min": [-0.8, 0.1, -0.8], "max": [0.8, 0.5, 0.8], "seed": 3}}},
    "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}],
    "contacts": [{"type": "mesh", "file": "roof.obj", "cell": 0.1, "restitution": 0.2}]})");
  const auto result = run(folder, "run scene.json --json --out roof.csv --every 60");
  CAPTURE(result.err);
  REQUIRE(result.exit == 0);
  const auto report = json::parse(result.out);
  CHECK(report["contacts"][0]["hits"] >= 100);
  CHECK(report["contacts"][0]["impulse"][1] < 0);
  const auto told = run(folder, "explain scene.json");
  CHECK(told.out.find("meshes       contacts[0]: 28 x 18 x 28 nodes, 56448 bytes, cells of 0.1 m: ") != std::string::npos);
  CHECK(run(folder, "verify scene.json").exit == 0);
  CHECK(run(folder, "run scene.json --out roof.html").exit == 0);
  const auto refused = run(folder, "run scene.json --set contacts[0].file=open.obj");
  CHECK(refused.exit == 3);
  CHECK(refused.err.starts_with("dvdx: scene.json: contacts[0].file is of an edge that only one triangle has: must be "));
}

TEST_CASE("verify holds a scene with a network against the reference") {
  const SheetFolder folder("verify");
  const auto result = run(folder, "verify sheet.json --json");
  CAPTURE(result.err);
  CHECK(result.exit == 0);
  const auto report = json::parse(result.out);
  CHECK(report["passed"] == true);
  REQUIRE(report["scenes"].size() == 3);
  CHECK(report["scenes"][0]["steps"] == 16);
  CHECK(report["scenes"][0]["sample"]["particles"] == 30);  // all: each moves the others
  const auto& fast = report["scenes"][0]["fast"];
  CHECK(fast["isas"] == report["scenes"][0]["contracted"]["isas"]);
  CHECK(fast["first_step"]["ulps"].get<double>() > 0);
  CHECK(fast["first_step"]["ulps"] <= fast["first_step"]["at_most"]);

  const auto alone = json::parse(run(folder, "verify sheet.json --json --arithmetic fast").out);
  CHECK(alone["passed"] == true);
  CHECK(alone["scenes"][0]["fast"] == fast);
  CHECK(alone["scenes"][0]["isas"].empty());
  CHECK(alone["scenes"][0]["contracted"]["isas"].empty());
  CHECK(alone["scenes"][0]["runs"] < report["scenes"][0]["runs"]);
  CHECK(run(folder, "verify sheet.json --arithmetic exact").exit == 2);
}

constexpr const char* jet = R"({
  "format": "dvdx-scene/1", "name": "jet", "step": 0.015625, "duration": 2, "capacity": 70,
  "emitters": [{"type": "disc", "center": [0, 0.1, 0], "normal": [0, 1, 0], "radius": 0.1, "rate": 100, "velocity": [0, 4, 0],
                "spread": 0.5, "lifetime": {"min": 0.2, "max": 0.9}, "seed": 4}],
  "removal": {"boundaries": [{"normal": [0, 1, 0], "offset": 0}]},
  "forces": [{"type": "constant", "acceleration": [0, -9.81, 0]}]
})";

TEST_CASE("run of a scene whose particles come and go tells how many, the same however it is run") {
  const ScratchFolder folder("command-jet");
  folder.write("jet.json", jet);
  const auto report_of = [&](const std::string& options) {
    const auto result = run(folder, "run jet.json --json " + options);
    CAPTURE(result.err);
    REQUIRE(result.exit == 0);
    return json::parse(result.out);
  };
  const auto own = report_of("");
  CHECK(own["born"] == 200);
  CHECK(own["dropped"] == 0);
  CHECK(own["particles"].get<int>() + own["removed"].get<int>() == 200);
  CHECK(own["particles"].get<int>() > 20);
  for (const char* options : {"--layout aos --threads 1 --isa reference", "--layout aosoa", "--every 3 --out a.csv"}) {
    CHECK(report_of(options)["state_hash"] == own["state_hash"]);
  }
  CHECK(report_of("--set emitters[0].seed=5")["state_hash"] != own["state_hash"]);
  CHECK(report_of("--set capacity=20")["dropped"].get<int>() > 0);
  CHECK(report_of("--set emitters[0].rate=0")["particles"] == 0);
  CHECK(run(folder, "run jet.json").out.find("200 born") != std::string::npos);
  CHECK(run(folder, "run jet.json --out a.pc2").exit == 2);
  CHECK(run(folder, "run jet.json --out a.html --error").exit == 2);
  CHECK(run(folder, "run jet.json --step -0.015625").exit == 3);
  CHECK(run(folder, "explain jet.json").out.find("at most 70 particles live at once") != std::string::npos);
  CHECK(run(folder, "report jet.json").exit == 3);
}

TEST_CASE("verify holds particles that come and go against the reference") {
  const ScratchFolder folder("command-verify-jet");
  folder.write("jet.json", jet);
  const auto result = run(folder, "verify jet.json --json");
  CAPTURE(result.err);
  CHECK(result.exit == 0);
  const auto report = json::parse(result.out);
  CHECK(report["passed"] == true);
  CHECK(report["scenes"][0]["steps"] == 128);
  CHECK(report["scenes"][0]["particles"].get<int>() > 20);
}

TEST_CASE("stability runs the cases that it is asked for, and writes what it found") {
  const Folder folder("stability");
  const auto result = run(folder, "stability --only cases --cases 25,24 --json --out found");
  CHECK(result.exit == 0);
  const auto found = json::parse(result.out);
  CHECK(found["machine"]["isas"].size() >= 1);
  REQUIRE(found["cases"].size() == 4);
  CHECK(found["cases"][0]["number"] == 24);
  CHECK(found["cases"][3]["number"] == 25);
  CHECK(found["cases"][3]["precision"] == "float32");
  // Every instruction set of the machine, and those that fuse once more.
  const auto& isas = found["cases"][3]["isas"];
  CHECK(isas.size() >= found["machine"]["isas"].size());
  for (const auto& isa : found["machine"]["isas"]) CHECK(std::count(isas.begin(), isas.end(), isa) == 1);
  CHECK(json::parse(folder.read("found/stability.json")) == found);
  CHECK(folder.entries() == 2);
}

TEST_CASE("stability refuses cases that there are not, and a place that it cannot write to") {
  const Folder folder("stability-usage");
  for (const char* arguments : {"--cases 0", "--cases 99", "--cases some", "--only pictures"}) {
    CAPTURE(arguments);
    CHECK(run(folder, std::string("stability ") + arguments).exit == 2);
  }
  CHECK(run(folder, "stability --cases 25 --only cases --out fall.json").exit == 4);
}

// The commands that `dvdx --help` lists after "Subcommands:", a line each: two spaces, the name, what it does.
std::vector<std::string> subcommands(const std::string& help) {
  const std::string heading = "Subcommands:\n";
  REQUIRE(help.find(heading) != std::string::npos);
  std::istringstream lines(help.substr(help.find(heading) + heading.size()));
  std::vector<std::string> names;
  for (std::string line; std::getline(lines, line) && line.starts_with("  ");) {
    names.push_back(line.substr(2, line.find(' ', 2) - 2));
  }
  return names;
}

TEST_CASE("dvdx alone lists the commands, a line each, and an example; help says what one takes") {
  const Folder folder("alone");
  const auto alone = run(folder, "");
  CHECK(alone.exit == 2);
  CHECK(alone.err.find("\nExample:\n  dvdx run ") != std::string::npos);
  const auto help = run(folder, "help");
  CHECK(help.exit == 0);
  CHECK(help.out == alone.err);
  for (const auto& name : subcommands(run(folder, "--help").out)) {
    CAPTURE(name);
    CHECK(alone.err.find("\n  " + name + " ") != std::string::npos);
    const auto one = run(folder, "help " + name);
    CHECK(one.exit == 0);
    CHECK(one.out == run(folder, name + " --help").out);
  }
  CHECK(run(folder, "help walk").err.starts_with("dvdx: walk is not a command: known are new, run, "));
}

TEST_CASE("new writes scenes that run as they stand, and leaves what is there") {
  const ScratchFolder folder("command-new");
  for (const std::string kind : {"cloth", "rope", "fountain", "grains"}) {
    CAPTURE(kind);
    const auto made = run(folder, "new " + kind + " " + kind + ".json");
    CHECK(made.exit == 0);
    CHECK(made.out.find("dvdx run " + kind + ".json --out " + kind + ".html") != std::string::npos);
    const auto text = folder.read(kind + ".json");
    CHECK(json::parse(text)["about"].get<std::string>().find("Change first: ") != std::string::npos);
    const auto result = run(folder, "run " + kind + ".json --strict --duration 0.5");
    CAPTURE(result.err);
    CHECK(result.exit == 0);
    const auto again = run(folder, "new cloth " + kind + ".json");
    CHECK(again.exit == 4);
    CHECK(again.err.find("is there already") != std::string::npos);
    CHECK(folder.read(kind + ".json") == text);
  }
  CHECK(run(folder, "new rope none/rope.json").exit == 4);
  CHECK(folder.entries() == 4);
}

TEST_CASE("help of every subcommand starts with an example of it and is no error") {
  const Folder folder("help");
  const auto help = run(folder, "--help");
  CHECK(help.exit == 0);
  CHECK(help.out.starts_with("Example:\n  dvdx "));
  const auto names = subcommands(help.out);
  CHECK(names.size() >= 6);
  for (const auto& name : names) {
    CAPTURE(name);
    const auto result = run(folder, name + " --help");
    CHECK(result.exit == 0);
    CHECK(result.out.starts_with("Example:\n  dvdx " + name + " "));
  }
  CHECK(run(folder, "--version").exit == 0);
}

}  // namespace command_test
