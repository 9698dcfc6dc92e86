// Runs the tests. Fails if a selection selects nothing: each pattern of --test-case, --source-file, --test-suite and of their
// exclusions must match a test case. A renamed file or case can then not silently shrink a stage.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace {

// Stores the number of test cases that a query finds.
class Count final : public doctest::IReporter {
 public:
  explicit Count(const doctest::ContextOptions& /*options*/) {}
  static unsigned found;
  void report_query(const doctest::QueryData& query) override { found = query.run_stats->numTestCasesPassingFilters; }
  void test_run_start() override {}
  void test_run_end(const doctest::TestRunStats& /*stats*/) override {}
  void test_case_start(const doctest::TestCaseData& /*test*/) override {}
  void test_case_reenter(const doctest::TestCaseData& /*test*/) override {}
  void test_case_end(const doctest::CurrentTestCaseStats& /*stats*/) override {}
  void test_case_exception(const doctest::TestCaseException& /*exception*/) override {}
  void subcase_start(const doctest::SubcaseSignature& /*subcase*/) override {}
  void subcase_end() override {}
  void log_assert(const doctest::AssertData& /*assertion*/) override {}
  void log_message(const doctest::MessageData& /*message*/) override {}
  void test_case_skipped(const doctest::TestCaseData& /*test*/) override {}
};
unsigned Count::found = 0;
REGISTER_REPORTER("count", 0, Count);

struct Filter {
  std::string_view option, abbreviation, includes;  // a pattern that excludes must match something by `includes`
};
constexpr std::array<Filter, 6> filters{{{"test-case", "tc", "test-case"},
                                         {"test-case-exclude", "tce", "test-case"},
                                         {"source-file", "sf", "source-file"},
                                         {"source-file-exclude", "sfe", "source-file"},
                                         {"test-suite", "ts", "test-suite"},
                                         {"test-suite-exclude", "tse", "test-suite"}}};

struct Selection {
  const Filter* filter;
  std::string patterns;  // separated by commas; \, is a comma within a pattern
};

// Accepts -tc=..., --tc=..., -test-case=... and so on, also with doctest's prefix dt-.
std::vector<Selection> selections_of(int argc, const char* const* argv) {
  std::vector<Selection> found;
  for (int i = 1; i < argc; ++i) {
    std::string_view argument(argv[i]);
    argument.remove_prefix(std::min(argument.find_first_not_of('-'), argument.size()));
    if (argument.substr(0, 3) == "dt-") argument.remove_prefix(3);
    const std::size_t end = argument.find('=');
    if (end == std::string_view::npos) continue;
    for (const Filter& filter : filters) {
      const auto name = argument.substr(0, end);
      if (name == filter.option || name == filter.abbreviation)
        found.push_back({&filter, std::string(argument.substr(end + 1))});
    }
  }
  return found;
}

std::vector<std::string> split(const std::string& patterns) {
  std::vector<std::string> list(1);
  for (std::size_t i = 0; i < patterns.size(); ++i) {
    if (patterns[i] == ',' && (i == 0 || patterns[i - 1] != '\\')) {
      list.emplace_back();
    } else {
      list.back() += patterns[i];
    }
  }
  return list;
}

unsigned count(std::vector<std::string> options) {
  options.insert(options.begin(), {"tests", "--count", "--reporters=count"});
  std::vector<const char*> argv;
  for (const std::string& option : options) argv.push_back(option.c_str());
  (void)doctest::Context(static_cast<int>(argv.size()), argv.data()).run();
  return Count::found;
}

bool selects_nothing(int argc, const char* const* argv) {
  std::vector<std::string> all;
  bool is_bad = false;
  for (const auto& [filter, patterns] : selections_of(argc, argv)) {
    all.push_back("--" + std::string(filter->option) + "=" + patterns);
    for (const std::string& pattern : split(patterns)) {
      if (count({"--" + std::string(filter->includes) + "=" + pattern}) > 0) continue;
      std::fprintf(stderr, "no test case matches '%s' of --%s\n", pattern.c_str(), std::string(filter->option).c_str());
      is_bad = true;
    }
  }
  if (is_bad || count(all) > 0) return is_bad;
  std::fputs("the selection selects no test case\n", stderr);
  return true;
}

}  // namespace

// LLVM's OpenMP keeps its memory for a finished caller's thread until the process ends.
extern "C" const char* __lsan_default_suppressions() { return "leak:libomp.so"; }

int main(int argc, char** argv) { return selects_nothing(argc, argv) ? 2 : doctest::Context(argc, argv).run(); }
