// Particles that come and go on several ranks, and their memory.
#include <doctest/doctest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/ranks.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace ranks::live_test {

// A page identifies particles by ids, which a checkpoint keeps.
TEST_CASE("ranks: particles that come and go have the bits, files, pages and impacts of one rank" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-live");
  folder.write("drops.json", drops());
  folder.write("playback.html", "<!-- dvdx data -->");
  const std::string viewer = "DVDX_VIEWER=.";
  for (const char* run_of : {"drops.json", "drops.json --precision float64 --layout aosoa"}) {
    CAPTURE(run_of);
    const std::string arguments = std::string("run ") + run_of + " --json --every 5 ";
    const auto alone = said(run(folder, arguments + "--threads 1 --out whole.html --events impacts.csv", viewer));
    CHECK(alone["dropped"] > 0);
    CHECK(alone["removed"] > 50);
    CHECK(folder.read("impacts.csv").size() > 1000);
    for (const int ranks : run_of == std::string("drops.json") ? std::vector{2, 3, 5} : std::vector{2}) {
      CAPTURE(ranks);
      const std::string more = ranks == 2 ? "--checkpoint at --checkpoint-every 7" : ranks == 3 ? "--resume at" : "";
      auto report = said(run(folder, arguments + "--threads 2 --out a.html --events e.csv " + more, launcher(ranks, viewer)));
      report.erase("resumed_at_step");
      CHECK(report == alone);
      CHECK(folder.read("a.html") == folder.read("whole.html"));
      CHECK(folder.read("e.csv") == folder.read("impacts.csv"));
    }
  }
  const auto refused = run_on(2, folder, "run drops.json --set removal.order=any");
  CHECK(refused.exit == 3);
  CHECK(times(refused.err, "removal.order any, by which a hole may be filled from another rank, cannot be split") == 1);
}

// Compares up to the contacts' sums, and for particles that come and go up to their ids.
TEST_CASE("ranks: a checkpoint of particles that come and go has the bytes of one rank's" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-live-checkpoint");
  folder.write("drops.json", drops());
  const std::string arguments = "run drops.json --every 5 --out a.csv --checkpoint at --checkpoint-every 29";
  const auto number_at = [](const std::string& bytes, std::size_t place, std::size_t size) {
    std::uint64_t number = 0;
    std::memcpy(&number, bytes.data() + place, size);
    return number;
  };
  const auto written = [&](const CommandResult& result) {
    REQUIRE_MESSAGE(result.exit == 0, result.err);
    const auto bytes = folder.read("at");
    const std::size_t data = 28 + number_at(bytes, 20, 4);
    std::filesystem::remove(folder / "at");  // otherwise the next checkpoint's states would take another name
    const std::uint64_t particles = number_at(bytes, data, 8);
    CHECK(particles > 40);
    const std::size_t ids = data + 24 + particles * 8 * sizeof(float) + 3 * 8;
    CHECK(number_at(bytes, ids, 8) == particles);
    return bytes.substr(0, ids + 8 + particles * 4 + 4) + folder.read("at.states");
  };
  const auto alone = written(run(folder, arguments));
  for (const int ranks : {2, 5}) CHECK(written(run_on(ranks, folder, arguments)) == alone);
}

// Bytes for each of eight ranks: each process records its peak memory.
std::vector<double> most_memory(const ScratchFolder& folder, const nlohmann::json& scene, const std::string& more) {
  folder.write("many.json", scene.dump());
  folder.write("most.sh", R"("$@" & process=$!
file=most.$OMPI_COMM_WORLD_RANK
while grep VmHWM /proc/$process/status > $file.now 2> $file.ended; do
  mv $file.now $file
  sleep 0.01
done
wait $process)");
  const auto result = run(folder, "run many.json --threads 1" + more, launcher(8) + " sh most.sh");
  REQUIRE_MESSAGE(result.exit == 0, result.err);
  std::vector<double> bytes;
  for (int rank = 0; rank < 8; ++rank) {
    const auto text = folder.read("most." + std::to_string(rank));
    bytes.push_back(1024 * std::stod(text.substr(text.find(':') + 1)));
  }
  return bytes;
}

TEST_CASE("ranks: no rank holds all particles that come and go" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-live-memory");
  constexpr std::size_t particles = 500'000;
  const auto of = [&](std::size_t capacity) {
    auto scene = nlohmann::json::parse(drops());
    scene["capacity"] = capacity;
    scene["particles"]["count"] = capacity - 10;
    scene["duration"] = 3 * scene["step"].get<double>();
    return most_memory(folder, scene, " --every 2 --out a.vtp --checkpoint at --checkpoint-every 2");
  };
  const auto few = of(100), many = of(particles);
  for (std::size_t rank = 0; rank < few.size(); ++rank) {
    CAPTURE(rank);
    CHECK(many[rank] - few[rank] < 8 * sizeof(float) * particles);
  }
}

// A whole sheet would take 24 bytes a particle for places and 64 for faces, twice while they are read. A rank holds an eighth
// of the rows, the rows that these depend on, and a plan's columns for both.
TEST_CASE("ranks: no rank holds a sheet whole" * doctest::skip(has_no_mpi)) {
  const ScratchFolder folder("ranks-sheet-memory");
  constexpr std::size_t rows = 512, columns = 512;
  const auto of = [&](std::size_t more_rows) {
    auto scene = nlohmann::json::parse(sheet());
    auto& network = scene["network"];
    network["rows"] = more_rows;
    network["columns"] = columns;
    network["edge_v"] = {0, 0, 0.002 * static_cast<double>(more_rows)};
    network["mass"] = 1e-6 * static_cast<double>(more_rows * columns);
    scene["step"] = 0.001;
    scene["duration"] = 2 * scene["step"].get<double>();
    return most_memory(folder, scene, " --json");
  };
  const auto few = of(64), many = of(rows);
  for (std::size_t rank = 0; rank < few.size(); ++rank) {
    CAPTURE(rank);
    CHECK(many[rank] - few[rank] < 48 * (rows - 64) * columns);
  }
}

TEST_CASE("ranks: explain tells how births are shared, and refuses --size and a removal in any order") {
  const ScratchFolder folder("ranks-births");
  folder.write("drops.json", drops());
  const auto told = run(folder, "explain drops.json --ranks 4 --particle-time 1e-6 --latency 1e-6");
  REQUIRE_MESSAGE(told.exit == 0, told.err);
  CHECK(told.out.find("6.172, of which a rank makes 1.543\n") != std::string::npos);  // (700 + 90) / 128
  CHECK(told.out.find("about 22.5 when all 90 live") != std::string::npos);
  CHECK(told.out.find("2.275e-05 s: 2.25e-05 s of particles, 2.5e-07 s of sums") != std::string::npos);
  CHECK(run(folder, "explain drops.json --ranks 4 --size 1e9").exit == 2);
  CHECK(run(folder, "explain drops.json --ranks 4 --set removal.order=any").exit == 3);
}

}  // namespace ranks::live_test
