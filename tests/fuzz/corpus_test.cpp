// Runs every input of the fuzzers' corpora without the fuzzing engine: seeds, and inputs of past failures.
#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "fuzz/files.hpp"
#include "fuzz/targets.hpp"
#include "scene_io/text_lines.hpp"

using namespace dvdx;

namespace corpus_test {

std::vector<std::filesystem::path> inputs_of(const fuzz::Target& target) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(fuzz::corpus() + "/" + std::string(target.name))) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

TEST_CASE("every input of the fuzzers' corpora keeps the promises") {
  for (const fuzz::Target& target : fuzz::targets) {
    const auto inputs = inputs_of(target);
    CHECK_MESSAGE(!inputs.empty(), std::string(target.name) << " has inputs");
    for (const auto& input : inputs) {
      const std::string bytes = tool::contents(input);
      CHECK_NOTHROW_MESSAGE(target.run(bytes), input.string());
    }
  }
}

}  // namespace corpus_test
