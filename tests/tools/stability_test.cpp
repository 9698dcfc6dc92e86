// The framework of the hard cases: all are present, and every miss, refusal and difference between machines is reported. The
// cases themselves run in `dvdx stability`.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "hard_cases/cases.hpp"
#include "hard_cases/show.hpp"
#include "hard_cases/suite.hpp"
#include "state/engine.hpp"
#include "support/isas.hpp"

namespace stability_test {

using namespace dvdx::tool;
using namespace dvdx::tool::stability;

std::vector<Row> run(const std::vector<Case>& cases) {
  return run_cases(cases, Duration::whole, [](std::size_t) {});
}

std::vector<Case> numbered(int number) {
  auto cases = all_cases();
  std::erase_if(cases, [&](const Case& c) { return c.number != number; });
  REQUIRE(cases.size() == 1);
  return cases;
}

Row run_check(Check check, double limit) {
  return run({{.number = 1,
               .name = "name",
               .hard = "hard",
               .bars = {{.check = check, .limit = limit, .unit = "m", .expected = "something"}}}})
      .front();
}

Worst of(double value) {
  Worst worst;
  worst.see(value, "there");
  return worst;
}

TEST_CASE("stability: the hard cases are numbered from 1 to the last, with names and bars of their own") {
  const auto cases = all_cases();
  REQUIRE(cases.back().number == last_case);
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    CAPTURE(cases[i].number);
    CHECK(cases[i].number == static_cast<int>(i) + 1);
    CHECK_FALSE(cases[i].name.empty());
    CHECK_FALSE(cases[i].hard.empty());
    CHECK_FALSE(cases[i].bars.empty());
    names.insert(cases[i].name);
    for (const Bar& bar : cases[i].bars) {
      const bool has_check = bar.check != nullptr;
      CHECK(has_check);
      CHECK_NOTHROW((void)named(precisions, bar.precision));
      CHECK(std::isfinite(bar.limit));
      CHECK_FALSE(bar.expected.empty());
    }
  }
  CHECK(names.size() == cases.size());
}

TEST_CASE("stability: a case meets its bars, and misses an impossible bar") {
  for (const int number : {1, 24, 25, 29}) {
    auto cases = numbered(number);
    CHECK(all_passed(run(cases)));
    for (Bar& bar : cases.front().bars) bar.limit = -1;
    for (const Row& row : run(cases)) CHECK_FALSE(row.passed());
  }
}

TEST_CASE("stability: a figure at its bar meets it, and a figure that is not a number or a refusal misses it") {
  const auto one = [](CaseRun&) { return of(1); };
  CHECK(run_check(one, 1).passed());
  CHECK(run_check(one, 1).note == "there");
  CHECK(run_check(one, 0.999).note == "there");
  CHECK_FALSE(run_check([](CaseRun&) { return of(std::numeric_limits<double>::quiet_NaN()); }, 1).passed());
  const Row refused = run_check([](CaseRun&) -> Worst { throw std::runtime_error("mass is 0"); }, 1);
  CHECK_FALSE(refused.passed());
  CHECK(refused.note == "refused: mass is 0");
}

TEST_CASE("stability: a figure that is not a number stays the worst") {
  Worst worst;
  worst.see(1, "first");
  worst.see(std::numeric_limits<double>::quiet_NaN(), "second");
  worst.see(2, "third");
  CHECK(std::isnan(worst.value));
  CHECK(worst.where == "second");
}

TEST_CASE("stability: a row fails if one instruction set has other bits or alone misses the bar") {
  const std::size_t isas = dvdx::available_isas().size();
  const auto missed_by_one = [](CaseRun& way) { return of(way.isa == dvdx::Isa::reference ? 5 : 0); };
  CHECK_FALSE(run_check(missed_by_one, 1).passed());
  const std::size_t contracted = dvdx::available_isas(dvdx::Arithmetic::contracted).size();
  CHECK(run_check(missed_by_one, 5).isas.size() == isas + contracted + (contracted - 1));  // fast lacks the reference
  if (!dvdx::test::has_several_isas()) return;
  const dvdx::Isa best = dvdx::available_isas().back();
  const auto other_bits = [](CaseRun& way) {
    if (way.isa == dvdx::available_isas().back()) ++way.bits;
    return of(0);
  };
  const Row row = run_check(other_bits, 1);
  CHECK_FALSE(row.passed());
  CHECK(row.note.find(std::string(name(best))) != std::string::npos);
  CHECK(row.note.find(std::string(name(best)) + " contracted") != std::string::npos);
  CHECK(row.note.find(" fast") == std::string::npos);  // fast arithmetic has its own bits
}

TEST_CASE("stability: a known miss is shown, passes at its figure, and fails beyond it") {
  const auto row_of = [](Check check) {
    return run({{.number = 1,
                 .name = "name",
                 .hard = "hard",
                 .bars = {{.check = check,
                           .limit = 1,
                           .unit = "",
                           .expected = "something",
                           .known_miss = KnownMiss{3, "a reason"}}}}})
        .front();
  };
  const Row miss = row_of([](CaseRun&) { return of(3); });
  CHECK(miss.verdict == Verdict::known_miss);
  CHECK(miss.passed());
  CHECK(miss.note.find("a reason") != std::string::npos);
  CHECK(to_text({miss}, Colour::plain).find("KNOWN MISS") != std::string::npos);
  CHECK(to_text({miss}, Colour::plain).find("0 of 1 bars met, 1 known to be missed") != std::string::npos);
  CHECK(to_json(std::vector{miss})[0]["known_miss"] == true);
  CHECK(row_of([](CaseRun&) { return of(1); }).verdict == Verdict::met);
  CHECK_FALSE(row_of([](CaseRun&) { return of(3.1); }).passed());
  CHECK_FALSE(row_of([](CaseRun&) { return of(std::numeric_limits<double>::quiet_NaN()); }).passed());
}

TEST_CASE("stability: a bar for the best instruction set runs on that one alone, separate and contracted") {
  const Row row =
      run({{.number = 1,
            .name = "name",
            .hard = "hard",
            .bars = {{.check = [](CaseRun& way) { return of(way.isa == dvdx::available_isas(way.arithmetic).back() ? 0 : 9); },
                      .limit = 1,
                      .unit = "",
                      .expected = "something",
                      .known_miss = {},
                      .runs_on = RunsOn::best_isa}}}})
          .front();
  CHECK(row.passed());
  CHECK(row.isas.size() == 2);
}

TEST_CASE("stability: a row as JSON and as text") {
  const Row row = run_check([](CaseRun&) { return of(2); }, 1);
  const auto json = to_json(std::vector{row});
  std::vector<std::string> keys;
  for (const auto& item : json.at(0).items()) keys.push_back(item.key());
  CHECK(keys == std::vector<std::string>{"number", "name", "hard", "precision", "expected", "bar", "got", "unit", "passed",
                                         "known_miss", "isas", "note"});
  CHECK(json[0]["got"] == 2);
  CHECK(json[0]["passed"] == false);
  const auto plain = to_text({row}, Colour::plain);
  CHECK(plain.find("FAIL  there") != std::string::npos);
  CHECK(plain.find("FAILED: 1 of 1 bars missed") != std::string::npos);
  CHECK(plain.find('\x1b') == std::string::npos);
  CHECK(to_text({row}, Colour::coloured).find("\x1b[31mFAIL\x1b[0m") != std::string::npos);
}

}  // namespace stability_test
