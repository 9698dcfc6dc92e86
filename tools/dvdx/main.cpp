#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <new>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "commands/commands.hpp"
#include "commands/typed.hpp"
#include "dvdx/build_info.hpp"
#include "files/temporary.hpp"
#include "output/console.hpp"
#include "ranks/agree.hpp"
#include "ranks/join.hpp"

namespace {

using dvdx::tool::Exit;

// Prints the example first. CLI11 stores it as the footer.
class ExampleFirst final : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    const auto example = app->get_footer();
    const auto help = CLI::Formatter::make_help(app, std::move(name), mode);
    return example.empty() ? help : "Example:\n  " + example + "\n\n" + help;
  }
  std::string make_footer(const CLI::App* /*app*/) const override { return ""; }
};

std::vector<CLI::App*> commands_of(CLI::App& app) {
  return app.get_subcommands([](CLI::App*) { return true; });
}

std::string unknown(CLI::App& app, const std::string& word) {
  std::string known;
  for (const CLI::App* const command : commands_of(app)) known += (known.empty() ? "" : ", ") + command->get_name();
  return word + " is not a command: known are " + known;
}

// The commands, a line each, and one example.
std::string overview(CLI::App& app) {
  std::string text = app.get_description() + "\n\n";
  for (const CLI::App* const command : commands_of(app)) {
    text += fmt::format("  {:<10} {}\n", command->get_name(), command->get_description());
  }
  return text + fmt::format("\nExample:\n  {}\n\n`dvdx help COMMAND` says more of one.\n", app.get_footer());
}

void add_help(CLI::App& app) {
  auto about = std::make_shared<std::string>();
  auto* command = app.add_subcommand("help", "Say what there is, or what one command takes");
  command->footer("dvdx help run");
  command->add_option("COMMAND", *about, "one of those that dvdx lists");
  command->callback([&app, about] {
    if (about->empty()) return dvdx::tool::print_answer(overview(app));
    for (const CLI::App* const each : commands_of(app)) {
      if (each->check_name(*about)) return dvdx::tool::print_answer(each->help(app.get_name()));
    }
    throw dvdx::tool::Fault(Exit::usage, unknown(app, *about));
  });
}

// CLI11 would report an unknown command as a missing one.
void refuse_unknown_command(CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  const std::string word = argv[1];
  const auto is_it = [&](const CLI::App* command) { return command->check_name(word); };
  const auto commands = commands_of(app);
  if (std::none_of(commands.begin(), commands.end(), is_it)) throw dvdx::tool::Fault(Exit::usage, unknown(app, word));
}

// Refuses several ranks: each would do all of the command's work. The first rank prints the message.
void refuse_ranks(const std::string& command) {
  const int size = dvdx::tool::ranks_started();
  if (size == 1) return;
  const auto ranks = dvdx::tool::join_ranks().ranks;
  if (ranks->rank() == 0) {
    dvdx::tool::print_message(fmt::format("dvdx {}: started as {} ranks: must be started as one", command, size));
  }
  dvdx::tool::wait_for_all(*ranks);
  throw dvdx::tool::Fault(Exit::usage, std::string());
}

int run(int argc, char** argv) {
  auto exit = Exit::done;
  CLI::App app("Runs particle scenes, and says how fast and how right they are.", "dvdx");
  app.formatter(std::make_shared<ExampleFirst>());
  app.footer("dvdx run flag.json --out flag.html");
  app.set_version_flag("--version", std::string(dvdx::build_info().version));
  app.require_subcommand(1);
  dvdx::tool::add_new(app, exit);
  dvdx::tool::add_run(app, exit);
  dvdx::tool::add_report(app, exit);
  dvdx::tool::add_tune(app, exit);
  dvdx::tool::add_explain(app, exit);
  dvdx::tool::add_verify(app, exit);
  dvdx::tool::add_stability(app, exit);
  dvdx::tool::add_merge(app, exit);
  dvdx::tool::add_info(app, exit);
  add_help(app);
  dvdx::tool::refuse_empty_texts(app);
  const auto is_of_one = [](CLI::App* each) { return each->get_name() != "run" && each->get_name() != "info"; };
  for (auto* const command : app.get_subcommands(is_of_one)) {
    command->parse_complete_callback([name = command->get_name()] { refuse_ranks(name); });
  }
  if (argc < 2) {
    dvdx::tool::print_progress(overview(app));
    return static_cast<int>(Exit::usage);
  }
  refuse_unknown_command(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::ostringstream answer;
    std::ostringstream message;
    const int code = app.exit(error, answer, message);
    dvdx::tool::print_answer(answer.str());
    dvdx::tool::print_progress(dvdx::tool::printable_lines(message.str()));
    return code == 0 ? 0 : static_cast<int>(Exit::usage);  // help and version are no errors
  }
  return static_cast<int>(exit);
}

// If several ranks share a fault, only one has a message.
int failed(Exit exit, std::string_view message) {
  if (!message.empty()) dvdx::tool::print_message(message);
  return static_cast<int>(exit);
}

}  // namespace

int main(int argc, char** argv) {
  dvdx::tool::remove_temporaries_on_signals();
  try {
    const int code = run(argc, argv);
    return std::fflush(stdout) == 0 ? code : failed(Exit::input_output, "the output cannot be written");
  } catch (const dvdx::tool::Fault& fault) {
    return failed(fault.exit(), fault.what());
  } catch (const std::bad_alloc&) {
    return failed(Exit::input_output, "there is not enough memory");
  } catch (const std::exception& error) {
    return failed(Exit::input_output, error.what());
  }
}
