// Output for a person: answers on stdout, messages on stderr, in the order of the calls even if both go to one file. JSON is
// not for a person: it is printed as it is.
#pragma once

#include <string>
#include <string_view>

namespace dvdx::tool {

// Returns text for one line. Names come from files, and a terminal obeys control characters in them. Control characters, those
// that turn the direction of the text, and bytes that are no UTF-8 are shown as \n, \x1b or \u202e.
[[nodiscard]] std::string printable(std::string_view text);

// The same for each line.
[[nodiscard]] std::string printable_lines(std::string_view text);

void print_answer(std::string_view text);    // makes each line printable
void print_json(std::string_view text);      // as it is
void print_message(std::string_view text);   // "dvdx: ..." on one line of stderr
void print_progress(std::string_view text);  // to stderr as it is

}  // namespace dvdx::tool
