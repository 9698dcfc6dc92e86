// Reads the closed-form results in tests/oracles: comma-separated, one header line, numbers with more digits than a double.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "support/paths.hpp"

namespace dvdx::test {

class Oracle {
 public:
  // `file` is a name in tests/oracles.
  explicit Oracle(const std::string& file) {
    std::ifstream in(oracles() + "/" + file);
    if (!in) throw std::runtime_error("no oracle " + file);
    std::string line;
    std::getline(in, line);
    columns_ = split(line, ',');
    while (std::getline(in, line)) {
      if (!line.empty()) rows_.push_back(split(line, ','));
    }
  }

  class Row {
   public:
    Row(const Oracle& oracle, std::size_t index) : oracle_(&oracle), index_(index) {}
    // Finds the first column whose name starts with `name`, if none is equal to it. Text that is not a number is an error.
    [[nodiscard]] const std::string& text(const std::string& name) const {
      return oracle_->rows_[index_][oracle_->column(name)];
    }
    [[nodiscard]] double operator[](const std::string& name) const { return number(text(name)); }
    // Numbers separated by spaces or semicolons.
    [[nodiscard]] std::vector<double> list(const std::string& name) const {
      std::vector<double> result;
      for (const std::string& part : split(text(name), ';')) {
        std::istringstream in(part);
        for (std::string word; in >> word;) result.push_back(number(word));
      }
      return result;
    }

   private:
    const Oracle* oracle_;
    std::size_t index_;
  };

  [[nodiscard]] std::size_t size() const { return rows_.size(); }
  [[nodiscard]] Row operator[](std::size_t index) const { return {*this, index}; }

 private:
  static std::vector<std::string> split(const std::string& line, char separator) {
    std::vector<std::string> parts;
    std::istringstream in(line);
    for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
    return parts;
  }
  // strtod reads 1e-4000 as 0, which is intended here.
  static double number(const std::string& text) {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (end == text.c_str()) throw std::runtime_error("no number: " + text);
    return value;
  }
  [[nodiscard]] std::size_t column(const std::string& name) const {
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (columns_[c] == name) return c;
    }
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (columns_[c].starts_with(name)) return c;
    }
    throw std::runtime_error("no column " + name);
  }

  std::vector<std::string> columns_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace dvdx::test
