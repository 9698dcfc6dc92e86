// dvdx run: its output on the terminal.
#include <doctest/doctest.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/close.hpp"
#include "tools/command_folders.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace command_folders::run_test {

using dvdx::test::is_close;
using dvdx::test::run;
using nlohmann::json;

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
  // --method also replaces each force's own method.
  CHECK(hash_of(folder, "--method exact") == hash_of(folder, "--set forces[0].method=exact --set forces[1].method=exact"));
}

TEST_CASE("a negative step runs time backwards") {
  const Folder folder("backwards");
  const auto result = run(folder, "run fall.json --step -0.25 --out a.csv");
  CHECK(result.exit == 0);
  CHECK(folder.read("a.csv").find("\n5,-1.25,0,") != std::string::npos);
}

TEST_CASE("run steps networks by the requested scheme and sub-steps, and reports both") {
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

TEST_CASE("run reports how many particles come and go, and the state is the same however it is run") {
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

}  // namespace command_folders::run_test
