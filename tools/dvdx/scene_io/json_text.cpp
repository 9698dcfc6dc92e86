#include "scene_io/json_text.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "scene_io/fault.hpp"

namespace dvdx::tool {
namespace {

using nlohmann::json;

struct Place {
  std::size_t line = 1;
  std::size_t column = 1;
};

Place place_of(std::string_view text, std::size_t position) {
  const auto before = text.substr(0, std::min(position, text.size()));
  const auto line_start = before.rfind('\n');
  return {.line = 1 + static_cast<std::size_t>(std::count(before.begin(), before.end(), '\n')),
          .column = line_start == std::string_view::npos ? before.size() : before.size() - line_start - 1};
}

// Returns the parser's words without its code and its position, which the message gives already.
std::string reason(const std::string& what) {
  const auto colon = what.find(": ");
  return colon == std::string::npos ? what : what.substr(colon + 2);
}

// Builds the tree event by event, so that the path of an error is known.
class TreeBuilder final : public nlohmann::json_sax<json> {
 public:
  TreeBuilder(const std::string& name, std::string_view text) : name_(name), text_(text) {}

  [[nodiscard]] json take() { return std::move(root_); }

  bool null() override { return put(nullptr); }
  bool boolean(bool value) override { return put(value); }
  bool number_integer(number_integer_t value) override { return put(value); }
  bool number_unsigned(number_unsigned_t value) override { return put(value); }
  bool number_float(number_float_t value, const string_t& /*text*/) override { return put(value); }
  bool string(string_t& value) override { return put(std::move(value)); }
  bool binary(binary_t& value) override { return put(std::move(value)); }
  bool start_object(std::size_t /*size*/) override { return open(json::object()); }
  bool start_array(std::size_t /*size*/) override { return open(json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& value) override {
    if (open_.back().value->contains(value)) {
      open_.back().key = value;
      fail(path() + " is there twice: a key may occur once in an object");
    }
    open_.back().key = value;
    return true;
  }

  bool parse_error(std::size_t position, const std::string& last_token, const json::exception& error) override {
    if (dynamic_cast<const json::out_of_range*>(&error) != nullptr) {
      fail(path() + " is " + last_token + ": must be a finite number");
    }
    const auto place = place_of(text_, position);
    const std::string what = reason(error.what());
    const auto says = [&](const char* words) { return what.find(words) != std::string::npos; };
    const bool cut_off = says("unexpected end of input") || says("missing closing quote");
    fail("line " + std::to_string(place.line) + ", column " + std::to_string(place.column) + where() + ": " +
         (cut_off ? "the file ends here, before the JSON does: is it cut off?" : "not JSON: " + what));
  }

 private:
  struct Open {
    json* value;
    std::string key;
  };

  [[noreturn]] void fail(const std::string& message) const { throw Fault(Exit::bad_scene, name_ + ": " + message); }

  [[nodiscard]] std::string path() const {
    std::string path;
    for (const auto& open : open_) {
      if (open.value->is_array()) {
        // An element that is open is in its array already; one that is being read is not.
        const std::size_t index = open.value->size() - (&open == &open_.back() ? 0 : 1);
        path += "[" + std::to_string(index) + "]";
      } else {
        path += (path.empty() ? "" : ".") + open.key;
      }
    }
    return path;
  }

  [[nodiscard]] std::string where() const {
    const auto at = path();
    return at.empty() ? "" : ", in " + at;
  }

  json& add(json&& value) {
    if (open_.empty()) return root_ = std::move(value);
    auto& parent = open_.back();
    if (!parent.value->is_array()) return (*parent.value)[parent.key] = std::move(value);
    parent.value->push_back(std::move(value));
    return parent.value->back();
  }

  template <class T>
  bool put(T&& value) {
    add(json(std::forward<T>(value)));
    return true;
  }

  bool open(json&& empty) {
    if (open_.size() == max_json_depth) {
      fail(path() + " is nested more than " + std::to_string(max_json_depth) + " deep: no scene is");
    }
    // While a container is open nothing is added to its parent, so the pointer stays good.
    json& added = add(std::move(empty));
    open_.push_back({&added, {}});
    return true;
  }

  bool close() {
    open_.pop_back();
    return true;
  }

  const std::string& name_;
  std::string_view text_;
  json root_;
  std::vector<Open> open_;
};

}  // namespace

json parse_json(const std::string& name, std::string_view text) {
  TreeBuilder builder(name, text);
  json::sax_parse(text, &builder);
  return builder.take();
}

std::string shown(const json& value) {
  constexpr std::size_t longest = 60;
  std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
  if (text.size() > longest) {
    std::size_t cut = longest - 3;
    while (cut > 0 && (static_cast<unsigned char>(text[cut]) & 0xC0U) == 0x80U) --cut;  // never inside a UTF-8 character
    text = text.substr(0, cut) + "...";
  }
  return text;
}

}  // namespace dvdx::tool
