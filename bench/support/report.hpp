// The bars and other figures, as a table and as JSON.
#pragma once

#include <string>
#include <vector>

#include "support/race.hpp"

namespace dvdx::bench {

struct Required {
  bool at_least = true;
  double bound = 0;
};

struct Bar {
  std::string name, note;
  Required required;
  double median = 0, lowest = 0, highest = 0;
  [[nodiscard]] bool is_met() const { return required.at_least ? median >= required.bound : median <= required.bound; }
};

struct Figure {
  std::string name;
  double value = 0;
  std::string unit, note;
};

// Prints each result at once.
class Report {
 public:
  Report();
  void bar(const std::string& name, Required required, const Race& race, const std::string& note = {});
  void figure(const std::string& name, double value, const std::string& unit, const std::string& note = {});
  void heading(const std::string& text);
  void table() const;  // all bars again, and the machine
  void write_json(const std::string& file) const;

 private:
  std::vector<Bar> bars_;
  std::vector<Figure> figures_;
  double load_at_start_;
};

}  // namespace dvdx::bench
