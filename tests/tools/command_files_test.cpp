// Files that the command reads and writes: it never overwrites an input, never reads an endless file, and never sends a name's
// control characters to a terminal.
#include <doctest/doctest.h>
#include <sys/stat.h>

#include <filesystem>
#include <locale>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "dvdx/layouts/soa.hpp"
#include "output/console.hpp"
#include "output/writer.hpp"
#include "report/summary.hpp"
#include "scene_io/fault.hpp"
#include "scene_io/file_text.hpp"
#include "tools/run_command.hpp"
#include "tools/scratch_folder.hpp"

namespace command_files_test {

namespace fs = std::filesystem;
using namespace dvdx::tool;
using dvdx::test::run;
using dvdx::test::ScratchFolder;

constexpr const char* from_files = R"({
  "format": "dvdx-scene/1", "name": "from files", "step": 0.125, "duration": 0.5,
  "particles": {"count": 2, "position": {"file": "points.csv"}},
  "forces": [{"type": "constant", "acceleration": [0, -8, 0]}]
})";
constexpr const char* points = "x,y,z\n0,1,0\n1,2,3\n";

class FilesFolder : public ScratchFolder {
 public:
  explicit FilesFolder(const std::string& name) : ScratchFolder("files-" + name) {
    write("scene.json", from_files);
    write("points.csv", points);
  }
};

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST_CASE("--out refuses to overwrite a file that the scene is read from, by whatever name") {
  const FilesFolder folder("sources");
  fs::create_hard_link(folder / "points.csv", folder / "linked.csv");
  fs::create_symlink("points.csv", folder / "pointing.csv");
  for (const char* out : {"points.csv", "./points.csv", "linked.csv", "pointing.csv"}) {
    CAPTURE(out);
    const auto result = run(folder, std::string("run scene.json --out ") + out);
    CHECK(result.exit == 2);
    CHECK(contains(result.err, out));
    CHECK(contains(result.err, "points.csv, which the scene is read from"));
  }
  CHECK(folder.read("points.csv") == points);
  CHECK(run(folder, "run scene.json --out other.csv").exit == 0);

  fs::copy_file(folder / "scene.json", folder / "scene.html");
  CHECK(run(folder, "run scene.html --out scene.html").exit == 2);
  CHECK(folder.read("scene.html") == from_files);
  fs::copy_file(folder / "scene.json", folder / "report.json");
  CHECK(run(folder, "report report.json --quick --out .").exit == 2);
  CHECK(folder.read("report.json") == from_files);
}

TEST_CASE("--out refuses a series with a frame that the scene is read from") {
  const FilesFolder folder("source-frame");
  REQUIRE(run(folder, "run scene.json --every 1 --out a.ply").exit == 0);  // a-000000.ply to a-000004.ply
  const auto frame = folder.read("a-000003.ply");
  const std::string again = "run scene.json --set particles.position.file=a-000003.ply --out a.ply --every ";
  CHECK(run(folder, again + "1").exit == 2);  // it would replace the input
  CHECK(run(folder, again + "0").exit == 2);  // it would remove the input, as a frame of a longer series
  CHECK(folder.read("a-000003.ply") == frame);
}

TEST_CASE("a rewritten series has no frames of the earlier one, and other files stay") {
  for (const char* extension : {"ply", "vtp"}) {
    CAPTURE(extension);
    const FilesFolder folder("series");
    const auto name = [&](const char* stem) { return std::string(stem) + "." + extension; };
    REQUIRE(run(folder, "run scene.json --every 1 --out " + name("a")).exit == 0);
    REQUIRE(run(folder, "run scene.json --every 1 --out " + name("ab")).exit == 0);
    for (const char* other : {"a-000077", "a-3", "a-0000003", "a"}) folder.write(name(other), "mine");
    REQUIRE(run(folder, "run scene.json --every 2 --out " + name("a")).exit == 0);
    for (const char* kept :
         {"a-000000", "a-000001", "a-000002", "ab-000003", "ab-000004", "a-000077", "a-3", "a-0000003", "a"}) {
      CAPTURE(kept);
      CHECK(fs::exists(folder / name(kept)));
    }
    for (const char* old : {"a-000003", "a-000004"}) CHECK_FALSE(fs::exists(folder / name(old)));
  }
}

TEST_CASE("a refused run leaves an earlier series unchanged") {
  const FilesFolder folder("unfinished");
  REQUIRE(run(folder, "run scene.json --every 1 --out a.ply").exit == 0);
  const auto before = folder.entries();
  CHECK(run(folder, "run scene.json --every 2 --set particles.count=3 --out a.ply").exit == 3);
  CHECK(folder.entries() == before);
}

TEST_CASE("a pipe or a device is refused as a scene and as a file of a scene") {
  const FilesFolder folder("pipes");
  REQUIRE(mkfifo((folder / "pipe.json").c_str(), 0600) == 0);
  REQUIRE(mkfifo((folder / "pipe.csv").c_str(), 0600) == 0);
  const auto refused = [&](const std::string& arguments, const std::string& what) {
    CAPTURE(arguments);
    const auto result = run(folder, arguments, "timeout 10");
    CHECK((result.exit == 3 || result.exit == 4));
    CHECK(contains(result.err, what));
    CHECK(contains(result.err, "must be a regular file"));
  };
  refused("run pipe.json", "it is a pipe");
  refused("run scene.json --set particles.position.file=pipe.csv", "it is a pipe");
  fs::create_symlink("/dev/zero", folder / "zero.csv");
  refused("run /dev/zero", "it is a device");
  refused("run scene.json --set particles.position.file=zero.csv", "it is a device");
}

TEST_CASE("a scene or data file beyond its limit is refused, and the error names the limit") {
  const FilesFolder folder("large");
  folder.write("large.json", "");
  fs::resize_file(folder / "large.json", scene_limit.bytes + 1);  // sparse: the disk stores nothing of it
  const auto result = run(folder, "explain large.json");
  CHECK(result.exit == 4);
  CHECK(contains(result.err, "it is larger than 256 MiB"));
  folder.write("large.csv", "");
  fs::resize_file(folder / "large.csv", data_limit.bytes + 1);
  const auto data = run(folder, "explain scene.json --set particles.position.file=large.csv");
  CHECK(data.exit == 3);
  CHECK(contains(data.err, "line 1 is longer than 16 MiB"));
  folder.write("large.obj", "");
  fs::resize_file(folder / "large.obj", data_limit.bytes + 1);
  const auto mesh = run(folder, R"(explain scene.json --set 'contacts=[{"type":"mesh","file":"large.obj"}]')");
  CHECK(mesh.exit == 3);
  CHECK(contains(mesh.err, "it is larger than 4 GiB"));
  CHECK(read_file(folder / "points.csv", {.bytes = 18, .text = "18 bytes"}) == std::string(points));
  CHECK_FALSE(read_file(folder / "points.csv", {.bytes = 17, .text = "17 bytes"}));
}

TEST_CASE("a scene names its files relative to its own place") {
  const FilesFolder folder("relative");
  const auto result = run(folder, "run scene.json --set particles.position.file=" + folder / "points.csv");
  CHECK(result.exit == 3);
  CHECK(contains(result.err, "must be a path relative to the scene file"));
  fs::create_directory(folder / "deep");
  fs::copy_file(folder / "scene.json", folder / "deep/scene.json");
  CHECK(run(folder, "run deep/scene.json --set particles.position.file=../points.csv").exit == 0);
}

TEST_CASE("file names made from scene names are short and distinct") {
  report::Report report{};
  const auto add = [&](const std::string& name) {
    report.scenes.emplace_back();
    report.scenes.back().scene = name;
  };
  add(std::string(400, 'a'));
  add(std::string(400, 'a') + "b");
  add("Two springs, damped");
  add("");
  const auto names = report::file_names(report);
  CHECK(names[0].size() == 100);
  CHECK(names[1] == names[0] + "-2");
  CHECK(names[2] == "two-springs-damped");
  CHECK(names[3] == "scene");
}

TEST_CASE("a file's own name may be as long as the file system allows") {
  const FilesFolder folder("long");
  const std::string stem(240, 'a');
  for (const char* extension : {".csv", ".npz", ".pc2", ".ply", ".vtp"}) {
    CAPTURE(extension);
    CHECK(run(folder, "run scene.json --every 2 --out " + stem + extension).exit == 0);
    CHECK(folder.entries() > 2);
  }
}

TEST_CASE("characters that a terminal would obey are shown as escapes, and all other text is unchanged") {
  CHECK(printable("plain ü Ω 中 🙂 \\") == "plain ü Ω 中 🙂 \\");
  CHECK(printable("\x1b[31mred\x1b[0m") == "\\x1b[31mred\\x1b[0m");
  CHECK(printable(std::string_view("a\0\a\b\t\n\r\x7f", 8)) == "a\\x00\\x07\\x08\\t\\n\\r\\x7f");
  CHECK(printable("\xc2\x9b"
                  "31m") == "\\u009b31m");
  CHECK(printable("\xe2\x80\xae"
                  "abc") == "\\u202eabc");
  CHECK(printable("\xff\xc3(\xc0\xaf\xed\xa0\x80") == "\\xff\\xc3(\\xc0\\xaf\\xed\\xa0\\x80");
  CHECK(printable("\xe4\xb8") == "\\xe4\\xb8");
  CHECK(printable_lines("a\n\x1b"
                        "b\n") == "a\n\\x1bb\n");
}

TEST_CASE("escape sequences in a scene or a file's name are shown in text, and kept in JSON") {
  const ScratchFolder folder("files-escapes");
  folder.write("scene.json", R"({
    "format": "dvdx-scene/1", "name": "\u001b[31mred\u001b[0m\nverified   yes", "about": "\u001b]0;title\u0007", "step": 0.125,
    "duration": 0.5, "particles": {"count": 2}, "forces": [{"type": "constant", "acceleration": [0, -8, 0]}]})");
  fs::copy_file(folder / "scene.json", folder / "\x1b[31m.json");
  const std::string name = "\x1b[31mred\x1b[0m\nverified   yes";
  for (const char* arguments :
       {"run scene.json", "explain scene.json", "verify scene.json", "report scene.json --quick --out .",
        "tune scene.json --error 0.1", "run 'none\x1b[31m.json'", "run '\x1b[31m.json' --out '\x1b[31mnone/a.csv'",
        "run scene.json --set '\x1b[31m=2'", "run scene.json '\x1b[31m'", "run scene.json --method '\x1b[31m'"}) {
    CAPTURE(std::string(arguments));
    const auto result = run(folder, arguments);
    CHECK_FALSE(contains(result.out + result.err, "\x1b"));
    CHECK(contains(result.out + result.err, "\\x1b[31m"));
    CHECK_FALSE(contains(result.out, "\nverified"));
  }
  const auto json = run(folder, "run scene.json --json");
  REQUIRE(json.exit == 0);
  CHECK(nlohmann::json::parse(json.out)["scene"] == name);
}

// A locale with decimal commas, for all streams made during its lifetime.
class CommaLocale {
 public:
  CommaLocale() : before_(std::locale::global(std::locale(std::locale::classic(), new Comma))) {}
  CommaLocale(const CommaLocale&) = delete;
  CommaLocale& operator=(const CommaLocale&) = delete;
  ~CommaLocale() { std::locale::global(before_); }

 private:
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  std::locale before_;
};

TEST_CASE("output does not depend on the locale") {
  const ScratchFolder folder("files-locale");
  dvdx::Soa<float> memory(12345);
  const auto write = [&](const std::string& target) {
    const auto writer = make_writer<float>({.target = target, .particles = 12345, .states = 1});
    auto state = memory.view();
    state.x[0][0] = 1234.5F;
    writer->write({.step = 1234567, .time = 1234.5}, state);
    writer->finish();
  };
  const std::string plain = folder / "plain";
  const std::string comma = folder / "comma";
  for (const char* extension : {".csv", ".ply", ".vtp", ".npz"}) write(plain + extension);
  {
    const CommaLocale locale;
    REQUIRE((std::ostringstream() << 1234.5).str() == "1.234,5");
    for (const char* extension : {".csv", ".ply", ".vtp", ".npz"}) write(comma + extension);
  }
  for (const char* extension : {".csv", "-000000.ply", "-000000.vtp", ".npz"}) {
    CAPTURE(extension);
    CHECK(folder.read(std::string("plain") + extension) == folder.read(std::string("comma") + extension));
  }
}

TEST_CASE("a report without its page has its numbers and pictures, and says so") {
  const FilesFolder folder("no-page");
  fs::create_directory(folder / "found");
  folder.write("found/report.html", "of an older report");
  const std::string command = "report scene.json --quick --precision float64 --out found";
  const auto without = run(folder, command, "DVDX_VIEWER=" + folder / "none");
  CHECK(without.exit == 0);
  CHECK(contains(without.err, "no report.html: the report page has not been built"));
  CHECK(contains(without.err, "written to found: report.json"));
  CHECK_FALSE(fs::exists(folder / "found/report.html"));
  CHECK(nlohmann::json::parse(folder.read("found/report.json"))["scenes"][0]["scene"] == "from files");
  folder.write("report.html", "<p>before</p><!-- dvdx data --><p>after</p>");
  const auto with = run(folder, command, "DVDX_VIEWER=.");
  CHECK(with.exit == 0);
  CHECK(contains(with.err, "written to found: report.html, report.json"));
  const auto page = folder.read("found/report.html");
  CHECK(page.starts_with("<p>before</p><script type=\"text/x-dvdx-report\">{"));
  CHECK(page.ends_with("</script>\n<p>after</p>"));
}

TEST_CASE("stdout and stderr redirected to one file keep the order of writing") {
  const FilesFolder folder("order");
  const auto result = run(folder, "report scene.json --quick --precision float64 --out found >both 2>&1; true");
  const auto both = folder.read("both");
  const auto written = both.find("dvdx: written to found");
  REQUIRE(written != std::string::npos);
  CHECK(both.find('\n', written) == both.size() - 1);
  CHECK(result.out.empty());
}

}  // namespace command_files_test
