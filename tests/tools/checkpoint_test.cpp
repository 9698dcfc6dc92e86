// A run that stops and resumes: the same bits and files as a run that never stopped.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "support/paths.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace checkpoint_test {

namespace fs = std::filesystem;
using dvdx::test::run;
using dvdx::test::ScratchFolder;
using nlohmann::json;

constexpr std::uint64_t steps = 60;

struct Small {
  std::string name;
  std::string text;
};

// One small scene of each kind, of `steps` steps.
std::vector<Small> small_scenes() {
  const std::string head = R"({"format": "dvdx-scene/1", "name": "small", "step": 0.0078125, "duration": 0.46875, )";
  const std::string gravity = R"({"type": "constant", "acceleration": [0, -9.81, 0]})";
  const std::string particles = R"("particles": {"count": 37, "mass": {"uniform": {"min": 0.5, "max": 2, "seed": 1}},
      "position": {"uniform": {"min": [0, 0.1, 0], "max": [1, 2, 1], "seed": 3}},
      "velocity": {"uniform": {"min": [-1, -1, -1], "max": [1, 1, 1], "seed": 4}}}, )";
  const auto sheet = [&](const std::string& more) {
    return head + R"("network": {"type": "grid", "rows": 6, "columns": 7, "origin": [0, 1, 0], "edge_u": [0.6, 0, 0],
      "edge_v": [0, 0, 0.5], "mass": 0.1, "structural": 80, "shear": 20, "bend": 3, )" +
           more + R"(}, "forces": [)" + gravity + "]";
  };
  const auto list = [&](const std::string& more) {
    std::string pairs;
    for (int i = 0; i + 1 < 37; ++i) pairs += (i == 0 ? "[" : ", [") + std::to_string(i) + ", " + std::to_string(i + 1) + "]";
    return head + particles +
           R"("network": {"type": "springs", "stiffness": 90, "damping": 0.2, "rest_length": "start", "pairs": [)" + pairs +
           "], " + more + R"(}, "forces": [)" + gravity + "]}";
  };
  const std::string gusts = R"({"type": "sinusoid", "acceleration": [3, 0, 1], "angular_frequency": 7, "phase": 0.3})";
  const std::string motion = R"("motions": {"hand": {"keys": [{"time": 0, "translation": [0, 0, 0]},
      {"time": 0.3, "translation": [0.2, 0.1, 0], "rotation": [0, 0.5, 0]}]}})";
  const std::string emitters = R"("capacity": 400, "particles": {"mass": 0.01}, "emitters": [
      {"type": "disc", "center": [0, 0.6, 0], "normal": [0, 1, 0], "radius": 0.04, "rate": 700, "velocity": [0, 3, 0], "spread": 0.7,
       "lifetime": {"min": 0.05, "max": 0.3}, "seed": 41}], )";
  const std::string floor =
      R"("contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0, "restitution": 0.5, "friction": 0.2}])";
  return {
      {"free",
       head + particles + R"("forces": [)" + gravity + ", " + gusts + R"(, {"type": "spring", "stiffness": 20, "damping": 0.2,
        "anchor": "start"}, {"type": "drag", "coefficient": 0.1, "wind": [1, 0, 0]}]})"},
      {"pulses", head + particles + R"("method": "pulse", "forces": [)" + gravity +
                     R"(, {"type": "radial_spring", "stiffness": 20, "rest_length": 0.5, "anchor": [0, 1, 0]}]})"},
      {"contacts", head + particles + R"("forces": [)" + gravity + "], " + floor + "}"},
      {"far", head + R"("particles": {"count": 5, "position": [1e6, 2, 0]}, "forces": [)" + gravity +
                  R"(, {"type": "spring", "stiffness": 20, "anchor": [1e6, 1, 0]}]})"},
      {"leapfrog", sheet(R"("fixed": "corners_top", "damping": 0.01)") + "}"},
      {"fourth order", sheet(R"("fixed": "edge_top", "scheme": "fourth_order")") + "}"},
      {"sweeps that carry on", sheet(R"("fixed": "corners_top", "scheme": "sequential", "damping": 0.01)") + "}"},
      {"sweeps by theta", sheet(R"("fixed": "corners_top", "scheme": "sequential", "theta": 0.6)") + "}"},
      {"list of sweeps", list(R"("scheme": "sequential")")},
      {"tearing sheet", sheet(R"("fixed": "corners_top", "tears_at": 1.02)") + "}"},
      {"tearing list", list(R"("scheme": "sequential", "tears_at": 1.02)")},
      {"accumulated", list(R"("scheme": "accumulate", "method": "pulse", "substeps": 4)")},
      {"carried", sheet(R"("scheme": "sequential", "damping": 0.01)") + ", " + motion +
                      R"(, "kinematic": [{"particles": "corners_top", "motion": "hand"}]})"},
      {"moving floor",
       head + particles + motion + R"(, "forces": [)" + gravity +
           R"(], "contacts": [{"type": "plane", "normal": [0, 1, 0], "offset": 0, "restitution": 0.5, "motion": "hand"}]})"},
      {"constraints", head + particles + R"("forces": [)" + gravity + R"(], "constraints": [
        {"type": "distance", "pairs": [[0, 1], [1, 2], [2, 3], [7, 8]], "length": "start"}, {"type": "point", "particle": 0, "at": [0, 1, 0]}]})"},
      {"grains", head + particles + R"("forces": [)" + gravity + "], " + floor +
                     R"(, "meet": {"radius": 0.07, "restitution": 0.3, "friction": 0.4, "apart_at_start": true}})"},
      {"cloth on itself",
       sheet(R"("scheme": "sequential", "substeps": 4)") + ", " + floor + R"(, "meet": {"thickness": 0.09}})"},
      {"come and go", head + emitters + R"("removal": {"not_finite": "removed"}, "forces": [)" + gravity + "], " + floor + "}"},
      {"come and go and meet", head + emitters +
                                   R"("removal": {"boundaries": [{"normal": [1, 0, 0], "offset": -0.3}]}, "forces": [)" +
                                   gravity + "], " + floor + R"(, "meet": {"radius": 0.02, "friction": 0.3}})"},
      {"come and go in any order", head + emitters +
                                       R"("removal": {"order": "any", "boundaries": [{"normal": [0, 1, 0], "offset": 0.3}]},
        "forces": [)" + gravity + ", " +
                                       gusts + "]}"},
  };
}

// A folder with the scenes, in which uninterrupted runs and their reports are compared.
class Folder : public ScratchFolder {
 public:
  explicit Folder(const std::string& name) : ScratchFolder("checkpoint-" + name) {
    viewer_.write("playback.html", "<!-- dvdx data -->");
    for (const auto& [scene, text] : small_scenes()) write(scene + ".json", text);
  }

  dvdx::test::CommandResult command(const std::string& arguments) const {
    return run(*this, arguments, "DVDX_VIEWER='" + viewer_.path().string() + "'");
  }
  // The --json report of a run that must succeed.
  json done(const std::string& arguments) const {
    const auto result = command(arguments + " --json");
    CAPTURE(arguments);
    CAPTURE(result.err);
    REQUIRE(result.exit == 0);
    return json::parse(result.out);
  }
  // Every file whose name begins with `start`, by the rest of its name.
  std::map<std::string, std::string> files(const std::string& start) const {
    std::map<std::string, std::string> all;
    for (const auto& entry : fs::directory_iterator(path())) {
      const auto name = entry.path().filename().string();
      if (name.starts_with(start)) all[name.substr(start.size())] = read(name);
    }
    return all;
  }
  void remove(const std::string& start) const {
    for (const auto& [name, bytes] : files(start)) fs::remove(path() / (start + name));
  }

 private:
  ScratchFolder viewer_{"checkpoint-viewer"};
};

// The part of a run's report that depends neither on its time nor on its machine.
json outcome(const json& report) {
  json same;
  for (const char* key :
       {"particles", "steps", "state_hash", "energy", "diverged", "born", "removed", "dropped", "torn", "heating"}) {
    if (report.contains(key)) same[key] = report[key];
  }
  return same;
}

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  std::size_t below(std::size_t end) { return engine_() % end; }
  template <class List>
  const auto& of(const List& list) {
    return list[below(list.size())];
  }

 private:
  std::mt19937 engine_;
};

std::string how(Random& random) {
  const std::array<const char*, 3> layouts{"soa", "aos", "aosoa"};
  const std::array<const char*, 3> isas{"best", "sse2", "reference"};
  return " --threads " + std::to_string(random.below(4) == 0 ? 2 : 1) + " --layout " + random.of(layouts) + " --isa " +
         random.of(isas);
}

// 120 cases of two commands each, about 10 ms a command.
TEST_CASE("a run resumed from a checkpoint at any step has the bits and the files of an uninterrupted run") {
  const Folder folder("any-step");
  const auto scenes = small_scenes();
  const std::array<const char*, 3> precisions{"float32", "float64", "float32_compensated"};
  const std::array<const char*, 6> extensions{"csv", "npz", "ply", "vtp", "pc2", "html"};
  std::map<std::string, json> whole;
  Random random(1);
  for (int n = 0; n < 120; ++n) {
    const auto& scene = scenes[static_cast<std::size_t>(n) % scenes.size()].name;
    const bool is_live = scene.starts_with("come and go");
    const std::string precision = is_live ? precisions[random.below(2)] : random.of(precisions);
    const std::string arithmetic = random.below(4) == 0 ? " --arithmetic contracted" : "";
    const bool is_contracted = !arithmetic.empty();
    std::string extension = random.of(extensions);
    if (is_live && (extension == "npz" || extension == "pc2")) extension = "csv";
    const std::string every = random.below(3) == 0 ? "0" : "7";
    const auto isa_of = [&](std::string options) {
      return is_contracted ? options.substr(0, options.find(" --isa")) : options;
    };
    const std::string start = "run '" + scene + ".json' --precision " + precision + arithmetic + " --every " + every;
    CAPTURE(start);
    CAPTURE(extension);

    const std::string key = start + extension;
    const std::string kept = "whole" + std::to_string(std::hash<std::string>{}(key)) + "x";
    if (!whole.contains(key)) whole[key] = folder.done(start + isa_of(how(random)) + " --out " + kept + "." + extension);
    // One checkpoint at any step: another would come after the end. Several if calls must end at given steps.
    const auto step = steps / 2 + 1 + random.below(steps / 2 - 1);
    const bool is_bound = precision == "float32_compensated";
    const auto often = std::to_string(is_bound ? 1 + random.below(9) : step);
    CAPTURE(step);
    const auto first =
        folder.done(start + isa_of(how(random)) + " --out first." + extension + " --checkpoint at --checkpoint-every " + often);
    CHECK(outcome(first) == outcome(whole[key]));
    const auto second = folder.done(start + isa_of(how(random)) + " --out second." + extension + " --resume at");
    CHECK(outcome(second) == outcome(whole[key]));
    if (!is_bound) CHECK(second["resumed_at_step"] == step);
    const auto expected = folder.files(kept);
    CHECK(expected.size() >= 1);
    for (const char* each : {"first", "second"}) {
      auto files = folder.files(each);
      if (extension == "vtp") {  // the series names its files
        for (auto* some : {&files}) {
          auto& pvd = (*some)[".pvd"];
          for (std::size_t at; (at = pvd.find(each)) != std::string::npos;) pvd.replace(at, std::string(each).size(), kept);
        }
      }
      CHECK(files == expected);
    }
    folder.remove("first");
    folder.remove("second");
    folder.remove("at");
  }
}

TEST_CASE("every damaged checkpoint is refused, and the error gives the reason") {
  const Folder folder("damaged");
  const std::string start = "run 'sweeps that carry on.json' --every 7 --out a.csv";
  folder.done(start + " --checkpoint at --checkpoint-every 40");
  const auto at = folder.read("at");
  const auto states = folder.read("at.states");
  Random random(2);
  for (int n = 0; n < 100; ++n) {
    auto bad = n % 5 == 4 ? states : at;
    // The checkpoint covers the first six of the ten states.
    const auto place = random.below(n % 5 == 4 ? bad.size() / 2 : bad.size());
    CAPTURE(n);
    CAPTURE(place);
    if (n % 3 == 0) {
      bad.resize(place);
    } else {
      bad[place] = static_cast<char>(bad[place] ^ (1 << random.below(8)));
    }
    folder.write(n % 5 == 4 ? "at.states" : "at", bad);
    const auto result = folder.command(start + " --resume at");
    CHECK(result.exit == 4);
    CHECK(result.err.starts_with("dvdx: at"));
    const bool is_named =
        result.err.find("is damaged") != std::string::npos || result.err.find("is no checkpoint") != std::string::npos;
    CHECK(is_named);
    folder.write("at", at);
    folder.write("at.states", states);
  }
  folder.write("at", at + "x");
  CHECK(folder.command(start + " --resume at").exit == 4);
  CHECK(folder.command(start + " --resume nowhere").exit == 4);
  CHECK(folder.command(start + " --resume .").exit == 4);
  folder.write("at", at);
  CHECK(folder.command(start + " --resume at").exit == 0);
  fs::remove(folder.path() / "at.states");
  CHECK(folder.command(start + " --resume at").exit == 4);
}

TEST_CASE("a checkpoint of another run is refused, and the error names the difference") {
  const Folder folder("another");
  folder.write("points.csv", "x,y,z\n0,1,0\n1,2,3\n");
  folder.write("points.json", R"({"format": "dvdx-scene/1", "name": "from a file", "step": 0.125, "duration": 2,
    "particles": {"count": 2, "position": {"file": "points.csv"}}, "forces": [{"type": "constant", "acceleration": [0, -8, 0]}]})");
  const auto refused = [&](const std::string& arguments, const std::string& reason) {
    CAPTURE(arguments);
    const auto result = folder.command(arguments + " --resume at --out b.csv --every 0");
    CHECK(result.exit == 3);
    CHECK(result.err.find(reason) != std::string::npos);
    CHECK(folder.files("b").empty());
  };
  const std::string start = "run points.json --checkpoint at --checkpoint-every 9";
  folder.done(start);
  for (const char* change : {"--set duration=3", "--duration 1", "--step 0.0625", "--set 'forces[0].acceleration=[0,-9,0]'",
                             "--method pulse", "--set name=other", "--set particles.mass=2"}) {
    refused(std::string("run points.json ") + change, "is a checkpoint of another scene");
  }
  refused("run free.json", "is a checkpoint of another scene, \"from a file\"");
  refused("run points.json --precision float64", "precision float32, and this run has float64");
  refused("run points.json --precision float32_compensated", "precision");
  refused("run points.json --arithmetic contracted", "arithmetic separate, and this run has contracted");
  CHECK(folder.command("run points.json --set duration=2.0 --resume at").exit == 0);  // the same number
  folder.write("points.csv", "x,y,z\n0,1,0\n1,2,4\n");
  refused("run points.json", "data files");
}

TEST_CASE("options that exclude each other, and states missing from a checkpoint, are refused before the run") {
  const Folder folder("options");
  const auto refused = [&](const std::string& arguments, int exit, const std::string& reason) {
    CAPTURE(arguments);
    const auto result = folder.command("run free.json " + arguments);
    CHECK(result.exit == exit);
    CHECK(result.err.find(reason) != std::string::npos);
  };
  refused("--checkpoint at", 2, "--checkpoint-every");
  refused("--checkpoint-every 5", 2, "--checkpoint");
  refused("--checkpoint at --checkpoint-every 0", 2, "--checkpoint-every");
  refused("--checkpoint free.json --checkpoint-every 5", 2, "which the scene is read from");
  refused("--checkpoint nowhere/at --checkpoint-every 5", 4, "there is no directory");
  folder.done("run free.json --checkpoint at --checkpoint-every 40");
  refused("--resume at --out a.csv --every 5", 2, "at has none of the states up to step 40");
  CHECK(folder.command("run free.json --resume at --out a.csv").exit == 0);  // the last state only
  folder.done("run free.json --checkpoint at --checkpoint-every 40 --out a.csv --every 7");
  refused("--resume at --out a.csv --every 5", 2, "at has the states of every 7 steps up to step 40");
  CHECK(folder.command("run free.json --resume at --out a.vtp --every 7").exit == 0);  // any format can be made from them
}

TEST_CASE("an unwritable checkpoint ends the run with the reason, and the earlier checkpoint stays") {
  const Folder folder("full");
  folder.done("run free.json --checkpoint at --checkpoint-every 40");
  const auto before = folder.read("at");
  const std::string big = "run free.json --set particles.count=60000 --checkpoint at --checkpoint-every 20";
  const auto result = run(folder, big, "ulimit -f 64;");
  CHECK(result.exit == 4);
  CHECK(result.err.find("at: cannot be written: File too large") != std::string::npos);
  CHECK(folder.read("at") == before);
  CHECK(folder.files(".at").empty());
}

// Runs the command as a process of its own and ends it by SIGKILL after `time`.
int killed_after(const ScratchFolder& folder, std::vector<std::string> arguments, std::chrono::milliseconds time) {
  arguments.insert(arguments.begin(), dvdx::test::command());
  std::vector<char*> pointers;
  for (auto& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  const pid_t pid = fork();
  if (pid == 0) {
    const int null = open("/dev/null", O_WRONLY);
    if (chdir(folder.path().c_str()) == 0 && dup2(null, 1) == 1 && dup2(null, 2) == 2) execv(pointers[0], pointers.data());
    _exit(127);
  }
  std::this_thread::sleep_for(time);
  kill(pid, SIGKILL);
  int status = 0;
  waitpid(pid, &status, 0);
  return status;
}

TEST_CASE("a run killed at any moment, again and again, comes to the same end") {
  const Folder folder("killed");
  for (const std::string scene : {"sweeps that carry on", "come and go"}) {
    CAPTURE(scene);
    // The run takes some tenths of a second.
    const std::string what = "run '" + scene + ".json' --duration 100 --every 100";
    const auto whole = outcome(folder.done(what + " --out whole.csv"));
    const std::vector<std::string> arguments{
        "run", scene + ".json",      "--duration", "100", "--every", "100", "--out", "killed.csv", "--checkpoint",
        "at",  "--checkpoint-every", "77"};
    Random random(3);
    int kills = 0;
    for (int n = 0; n < 12; ++n) {
      auto now = arguments;
      if (fs::exists(folder.path() / "at")) now.insert(now.end(), {"--resume", "at"});
      const int status = killed_after(folder, now, std::chrono::milliseconds(random.below(120)));
      if (WIFSIGNALED(status)) ++kills;
      if (WIFEXITED(status)) CHECK(WEXITSTATUS(status) == 0);
    }
    CHECK(kills > 0);
    const std::string go_on = fs::exists(folder.path() / "at") ? " --resume at" : "";
    CHECK(outcome(folder.done(what + " --out killed.csv" + go_on)) == whole);
    CHECK(folder.read("killed.csv") == folder.read("whole.csv"));
    folder.remove("at");
  }
}

}  // namespace checkpoint_test
