// A signal, a full disk or a limit on file sizes leaves only the files that were there before.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "files/part_name.hpp"
#include "support/paths.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace interrupted_test {

using dvdx::test::run;
using dvdx::test::ScratchFolder;

// Runs for hours unless it is ended.
constexpr const char* endless = R"({
  "format": "dvdx-scene/1", "name": "endless", "step": 0.001, "duration": 1000000,
  "particles": {"count": 50, "position": {"uniform": {"min": [0, 1, 0], "max": [1, 9, 1], "seed": 3}}},
  "forces": [{"type": "constant", "acceleration": [0, -8, 0]}, {"type": "spring", "stiffness": 2, "anchor": "start"}]
})";

class EndlessFolder : public ScratchFolder {
 public:
  explicit EndlessFolder(const std::string& name) : ScratchFolder("interrupted-" + name) { write("endless.json", endless); }

  [[nodiscard]] std::size_t parts() const {
    const std::filesystem::directory_iterator all(path());
    return static_cast<std::size_t>(std::count_if(begin(all), end(all), [](const auto& entry) {
      return entry.path().filename().string().find(".part-") != std::string::npos;
    }));
  }
};

// The command as a process of its own, with the signals of a shell's foreground job.
class Child {
 public:
  Child(const ScratchFolder& folder, std::vector<std::string> arguments, int ignored = 0) {
    arguments.insert(arguments.begin(), dvdx::test::command());
    std::vector<char*> pointers;
    for (auto& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    pid_ = fork();
    if (pid_ != 0) return;
    for (const int signal : {SIGHUP, SIGINT, SIGTERM, SIGQUIT, SIGPIPE, SIGXCPU}) std::signal(signal, SIG_DFL);
    if (ignored != 0) std::signal(ignored, SIG_IGN);
    const int null = open("/dev/null", O_RDWR);
    if (chdir(folder.path().c_str()) == 0 && dup2(null, 0) == 0 && dup2(null, 1) == 1 && dup2(null, 2) == 2) {
      execv(pointers[0], pointers.data());
    }
    _exit(127);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    if (pid_ > 0) (void)end_by(SIGKILL);
  }

  void send(int signal) const { kill(pid_, signal); }

  // Returns the wait status.
  int end_by(int signal) {
    send(signal);
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return status;
  }

 private:
  pid_t pid_;
};

bool comes_true(const std::function<bool()>& condition) {
  using namespace std::chrono_literals;
  const auto end = std::chrono::steady_clock::now() + 60s;
  while (std::chrono::steady_clock::now() < end) {
    if (condition()) return true;
    std::this_thread::sleep_for(5ms);
  }
  return false;
}

TEST_CASE("a signal that ends a run leaves no part file of any format, and is the exit status") {
  struct Format {
    const char* out;
    std::size_t parts;  // part files that exist while it is written
    int signal;
  };
  for (const Format& format :
       {Format{"a.csv", 1, SIGINT}, Format{"a.npz", 1, SIGTERM}, Format{"a.ply", 5, SIGHUP}, Format{"a.vtp", 5, SIGINT},
        Format{"a.pc2", 2, SIGQUIT}, Format{"a.html", 1, SIGINT}, Format{"a.csv", 1, SIGXCPU}}) {
    const char* const out = format.out;
    const int signal = format.signal;
    CAPTURE(out);
    CAPTURE(signal);
    const EndlessFolder folder("run");
    const ScratchFolder viewer("interrupted-viewer");
    viewer.write("playback.html", "<!-- dvdx data -->");
    setenv("DVDX_VIEWER", viewer.path().c_str(), 1);
    const std::string every = std::string_view(out) == "a.ply" || std::string_view(out) == "a.vtp" ? "100000" : "1000";
    Child child(folder, {"run", "endless.json", "--every", every, "--out", out, "--threads", "2"});
    unsetenv("DVDX_VIEWER");
    REQUIRE(comes_true([&] { return folder.parts() >= format.parts; }));
    const int status = child.end_by(signal);
    CHECK(WIFSIGNALED(status));
    CHECK(WTERMSIG(status) == signal);
    CHECK(folder.entries() == 1);
  }
}

TEST_CASE("the next run to the same target removes the part files of a killed run") {
  for (const std::string out : {"a.csv", "a.npz", "a.ply", "a.vtp", "a.pc2"}) {
    CAPTURE(out);
    const EndlessFolder folder("killed");
    const std::string every = out == "a.ply" || out == "a.vtp" ? "100000" : "1000";
    {
      Child child(folder, {"run", "endless.json", "--every", every, "--out", out, "--threads", "2"});
      REQUIRE(comes_true([&] { return folder.parts() >= 1; }));
      CHECK(WTERMSIG(child.end_by(SIGKILL)) == SIGKILL);
    }
    CHECK(folder.parts() >= 1);
    REQUIRE(run(folder, "run endless.json --duration 1 --every 500 --out " + out).exit == 0);
    CHECK(folder.parts() == 0);
    CHECK(folder.entries() > 1);
  }
}

TEST_CASE("runs with --events, reports and pictures remove the part files of killed runs") {
  const EndlessFolder folder("killed-others");
  folder.write("flag.json", R"({"format": "dvdx-scene/1", "name": "flag", "step": 0.01, "duration": 0.1,
    "network": {"type": "grid", "rows": 8, "columns": 8, "origin": [0, 0, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0, 1],
                "mass": 0.1, "structural": 10}})");
  const auto left = [&] {
    Child child(folder, {"run", "endless.json", "--events", "e.csv", "--threads", "2"});
    REQUIRE(comes_true([&] { return folder.parts() == 1; }));
    (void)child.end_by(SIGKILL);
  };
  for (const std::string line : {"run endless.json --duration 0.1 --events e.csv", "report flag.json --quick --out .",
                                 "explain flag.json --ranks 2 --picture p.svg"}) {
    CAPTURE(line);
    left();
    REQUIRE(folder.parts() == 1);
    CHECK(run(folder, line).exit == 0);
    CHECK(folder.parts() == 0);
  }
}

TEST_CASE("part files of a running process stay, and so do files whose names identify no ended process") {
  const EndlessFolder folder("both");
  Child child(folder, {"run", "endless.json", "--every", "1000", "--out", "a.csv", "--threads", "1"});
  REQUIRE(comes_true([&] { return folder.parts() == 1; }));
  const std::string mine = dvdx::tool::part_beside("b.csv").string();  // of a living process
  const auto last_dash = mine.rfind('-');
  const std::string start = mine.substr(last_dash + 1);
  const auto gone = [] {
    const pid_t process = fork();
    if (process == 0) _exit(0);
    waitpid(process, nullptr, 0);
    return std::to_string(process);
  }();
  const auto first_dash = mine.find(".part-") + 6;
  const std::string here = mine.substr(first_dash, 16);
  const std::string elsewhere = here == "0123456789abcdef" ? "1123456789abcdef" : "0123456789abcdef";
  const std::vector<std::string> kept{mine,
                                      ".b.csv.part-" + gone,  // in the form of older versions
                                      ".b.csv.part-" + elsewhere + "-" + gone + "-1",
                                      ".b.csv.part-" + here + "-" + gone + "-1.txt",
                                      ".b.csv.part-" + here + "-" + gone,
                                      ".b.csv.part-" + here + "-" + gone + "-",
                                      ".b.csv.part-" + here + "-0-1",
                                      "b.csv.part-" + here + "-" + gone + "-1"};
  const std::vector<std::string> removed{".b.csv.part-" + here + "-" + gone + "-1",
                                         mine.substr(0, last_dash + 1) + std::to_string(std::stoull(start) + 1)};
  for (const auto* names : {&kept, &removed}) {
    for (const std::string& name : *names) folder.write(name, "?");
  }
  CHECK(run(folder, "run endless.json --duration 1 --out a.csv").exit == 0);
  for (const std::string& name : kept) CHECK_MESSAGE(std::filesystem::exists(folder / name), name);
  for (const std::string& name : removed) CHECK_MESSAGE(!std::filesystem::exists(folder / name), name);
  CHECK(folder.parts() == kept.size() + 1);
  CHECK(std::filesystem::exists(folder / "a.csv"));
  CHECK(WTERMSIG(child.end_by(SIGINT)) == SIGINT);
  CHECK(folder.parts() == kept.size());
}

TEST_CASE("a signal that ends a report or the hard cases leaves no directory made by them") {
  for (const int signal : {SIGINT, SIGTERM}) {
    CAPTURE(signal);
    const EndlessFolder folder("report");
    const auto is_made = [&] { return std::filesystem::exists(folder / "deep/found"); };
    {
      Child child(folder, {"report", "endless.json", "--out", "deep/found"});
      REQUIRE(comes_true(is_made));
      CHECK(WTERMSIG(child.end_by(signal)) == signal);
    }
    CHECK(folder.entries() == 1);
    Child child(folder, {"stability", "--out", "deep/found"});
    REQUIRE(comes_true(is_made));
    CHECK(WTERMSIG(child.end_by(signal)) == signal);
    CHECK(folder.entries() == 1);
  }
}

TEST_CASE("a signal leaves an existing directory and its files") {
  const EndlessFolder folder("kept");
  std::filesystem::create_directory(folder / "found");
  folder.write("found/other.txt", "mine");
  Child child(folder, {"stability", "--out", "found"});
  using namespace std::chrono_literals;
  std::this_thread::sleep_for(100ms);
  (void)child.end_by(SIGINT);
  CHECK(folder.read("found/other.txt") == "mine");
}

// The signal arrives during the steps, before the output is next examined.
TEST_CASE("a signal leaves the first checkpoint, and the states and impacts that belong to it") {
  const EndlessFolder folder("checkpoint");
  Child child(folder, {"run", "endless.json", "--set", "particles.count=20000", "--every", "800", "--out", "a.csv", "--events",
                       "e.csv", "--checkpoint", "at", "--checkpoint-every", "800", "--threads", "1"});
  REQUIRE(comes_true([&] { return std::filesystem::exists(folder / "at"); }));
  CHECK(WTERMSIG(child.end_by(SIGTERM)) == SIGTERM);
  CHECK(std::filesystem::exists(folder / "at.states"));
  CHECK(std::filesystem::exists(folder / "at.events"));
  CHECK(folder.parts() == 0);
}

TEST_CASE("a signal that the program was started to ignore stays ignored") {
  const EndlessFolder folder("ignored");
  Child child(folder, {"run", "endless.json", "--every", "1000", "--out", "a.csv"}, SIGHUP);
  REQUIRE(comes_true([&] { return folder.parts() == 1; }));
  child.send(SIGHUP);
  CHECK(WTERMSIG(child.end_by(SIGTERM)) == SIGTERM);
  CHECK(folder.entries() == 1);
}

TEST_CASE("a file that grows beyond the limit on file sizes is exit 4, and leaves no part") {
  for (const char* out : {"a.csv", "a.npz", "a.ply", "a.vtp", "a.pc2"}) {
    CAPTURE(out);
    const EndlessFolder folder("limit");
    const auto result =
        run(folder, std::string("run endless.json --duration 4 --every 4 --set particles.count=5000 --out ") + out,
            "ulimit -f 16;");
    CHECK(result.exit == 4);
    CHECK(result.err.find("File too large") != std::string::npos);
    CHECK(folder.entries() == 1);
  }
}

TEST_CASE("a report that cannot be written is exit 4, and leaves neither a file nor the directory") {
  const ScratchFolder folder("interrupted-report-limit");
  folder.write("brief.json", R"({
    "format": "dvdx-scene/1", "name": "brief", "step": 0.125, "duration": 0.5, "particles": {"count": 2},
    "forces": [{"type": "constant", "acceleration": [0, -8, 0]}]})");
  const auto result = run(folder, "report brief.json --quick --precision float64 --out deep/found", "ulimit -f 4;");
  CHECK(result.exit == 4);
  CHECK(folder.entries() == 1);
}

}  // namespace interrupted_test
