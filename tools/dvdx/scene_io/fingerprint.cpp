#include "scene_io/fingerprint.hpp"

#include <bit>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "scene_io/fault.hpp"

namespace dvdx::tool {
namespace {

using nlohmann::json;

// FNV-1a, as for states.
class Hash {
 public:
  void add(std::string_view bytes) {
    for (const char byte : bytes) value_ = (value_ ^ static_cast<unsigned char>(byte)) * 0x100000001B3U;
  }
  // Adds a text with its length, so that adjacent texts do not run together.
  void add_text(std::string_view text) {
    add(std::to_string(text.size()) + ":");
    add(text);
  }
  [[nodiscard]] std::uint64_t value() const noexcept { return value_; }

 private:
  std::uint64_t value_ = 0xCBF29CE484222325U;
};

// 40, 40.0 and 4e1 are one number.
void add_number(Hash& hash, const json& value) {
  constexpr double exact = 9007199254740992;  // up to here every whole number is a double
  if (value.is_number_float()) {
    const double number = value.get<double>();
    if (std::abs(number) <= exact && std::trunc(number) == number) {
      hash.add_text(std::to_string(static_cast<std::int64_t>(number)));
    } else {
      hash.add_text("f" + std::to_string(std::bit_cast<std::uint64_t>(number)));
    }
  } else {
    hash.add_text(value.dump());
  }
}

void add_value(Hash& hash, const json& value) {  // NOLINT(misc-no-recursion): the reader limits the depth
  if (value.is_object()) {
    hash.add("{");
    for (const auto& [key, each] : value.items()) {
      hash.add_text(key);
      add_value(hash, each);
    }
    hash.add("}");
  } else if (value.is_array()) {
    hash.add("[");
    for (const auto& each : value) add_value(hash, each);
    hash.add("]");
  } else if (value.is_number()) {
    add_number(hash, value);
  } else {
    hash.add_text(value.dump());
  }
}

void add_file(Hash& hash, const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> some(std::size_t{1} << 18U);
  std::uint64_t bytes = 0;
  while (file.read(some.data(), static_cast<std::streamsize>(some.size())), file.gcount() > 0) {
    const auto got = static_cast<std::size_t>(file.gcount());
    hash.add({some.data(), got});
    bytes += got;
  }
  if (file.bad() || bytes == 0) throw Fault(Exit::input_output, path.string() + ": cannot be read");
  hash.add_text(std::to_string(bytes));
}

}  // namespace

std::uint64_t fingerprint_of(const SceneFile& file, const ReadOptions& options) {
  auto root = read_json(file.path, options);
  root["step"] = file.step;
  root["duration"] = file.duration;
  Hash hash;
  add_value(hash, root);
  for (const auto& source : file.sources) {
    if (source != file.path) add_file(hash, source);
  }
  return hash.value();
}

}  // namespace dvdx::tool
