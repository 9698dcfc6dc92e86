// Several ranks: their start, and their common end.
#include <doctest/doctest.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "support/paths.hpp"
#include "tools/ranks.hpp"
#include "tools/run_command.hpp"

namespace ranks::launch_test {

TEST_CASE("ranks: a run reports the number of ranks if a launcher started them, and only once" * doctest::skip(has_no_mpi)) {
  const MixedFolder folder("count");
  CHECK_FALSE(nlohmann::json::parse(run(folder, "run mixed.json --json").out).contains("ranks"));
  for (const int ranks : {1, 3}) {
    const auto result = run_on(ranks, folder, "run mixed.json --json --threads 2");
    REQUIRE(result.exit == 0);
    CHECK(nlohmann::json::parse(result.out).at("ranks") == ranks);
    CHECK(nlohmann::json::parse(result.out).at("particles") == 53);
    CHECK(result.err.empty());
  }
}

TEST_CASE("ranks: a command that does not share its work is refused once" * doctest::skip(has_no_mpi)) {
  const MixedFolder folder("one");
  for (const char* arguments : {"explain mixed.json", "report mixed.json", "verify mixed.json", "merge a.json"}) {
    const auto result = run_on(3, folder, arguments);
    CAPTURE(result.err);
    CHECK(result.exit == 2);
    CHECK(result.out.empty());
    const auto said = result.err.find(": started as 3 ranks: must be started as one");
    REQUIRE(said != std::string::npos);
    CHECK(result.err.find("must be started as one", said + 30) == std::string::npos);
  }
  CHECK(run_on(1, folder, "explain mixed.json").exit == 0);
}

TEST_CASE("ranks: a fault on one rank ends all ranks, is reported once and leaves no file" * doctest::skip(has_no_mpi)) {
  const MixedFolder folder("faults");
  const auto before = folder.entries();
  const auto check = [&](const std::string& arguments, int exit, const std::string& message) {
    CAPTURE(arguments);
    const auto result = run_on(3, folder, "run mixed.json " + arguments);
    CHECK(result.exit == exit);
    CHECK_MESSAGE(times(result.err, message) == 1, result.err);
    CHECK(result.out.empty());
    CHECK(folder.entries() == before);
  };
  check("--set step=-1", 3, "step is -1");
  // Only the last rank holds this particle.
  check(
      "--set particles.position='{\"values\":[" +
          [] {
            std::string list;
            for (int i = 0; i < 52; ++i) list += "[0,1,0],";
            return list;
          }() +
          "[1e300,1,0]]}'",
      3, "particle 52");
  check("--out nowhere/all.csv", 4, "there is no directory nowhere");
  check("--out all.html", 2, "a page is not written by several ranks");
  check(
      "--set 'network={\"type\":\"springs\",\"pairs\":[[0,1]],\"stiffness\":1,\"rest_length\":1,\"tears_at\":2,"
      "\"scheme\":\"sequential\",\"lines\":\"none\"}'",
      3, "network.tears_at by scheme sequential cannot be split over ranks");
  check("--set 'network={\"type\":\"springs\",\"pairs\":[[0,1]],\"stiffness\":1,\"rest_length\":1,\"scheme\":\"sequential\"}'",
        3, "network.lines is rows");
  check("--set 'constraints=[{\"type\":\"distance\",\"pairs\":[[0,1]],\"length\":1}]'", 3, "constraints cannot be split");
}

TEST_CASE("ranks: a killed rank ends the others, no file is half written, and the run can be resumed" *
          doctest::skip(has_no_mpi)) {
  const MixedFolder folder("killed");
  const std::string what = "run mixed.json --duration 4000 --every 50000 --json --threads 1 ";
  const auto whole = said(run(folder, what + "--out whole.csv"));
  const auto start = std::chrono::steady_clock::now();
  // After the first checkpoint one rank is killed. The launcher is the ranks' parent.
  folder.write("kill.sh", R"("$@" & launcher=$!
for n in $(seq 300); do
  [ -e at ] && break
  sleep 0.1
done
ranks=$(pgrep -P $launcher -x dvdx)
kill -9 ${ranks##* }
wait $launcher)");
  const auto killed = run(folder, what + "--out all.csv --checkpoint at --checkpoint-every 5000", launcher(3, "sh kill.sh"));
  CHECK(killed.exit != 0);
  CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(60));
  CHECK_FALSE(std::filesystem::exists(folder / "all.csv"));
  auto report = said(run_on(2, folder, what + "--out all.csv --resume at"));
  CHECK(report.contains("resumed_at_step"));
  report.erase("resumed_at_step");
  CHECK(report == whole);
  CHECK(folder.read("all.csv") == folder.read("whole.csv"));
}

}  // namespace ranks::launch_test
