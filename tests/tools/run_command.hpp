// Runs the command as a user does from a shell.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "support/paths.hpp"
#include "tools/scratch_folder.hpp"

namespace dvdx::test {

struct CommandResult {
  int exit;
  std::string out;
  std::string err;
};

// The command's output goes to files beside `folder`, so that it does not change the number of entries in the folder.
inline CommandResult run(const ScratchFolder& folder, const std::string& arguments, const std::string& environment = "") {
  const auto beside = folder.path().string();
  const std::string line = "cd '" + beside + "' && " + environment + " '" + command() + "' " + arguments + " >'" + beside +
                           ".out' 2>'" + beside + ".err' </dev/null";
  const int status = std::system(line.c_str());
  const auto take = [&](const char* extension) {
    const std::string name = folder.path().filename().string() + extension;
    auto text = folder.read("../" + name);
    std::filesystem::remove(beside + extension);
    return text;
  };
  return {.exit = WEXITSTATUS(status), .out = take(".out"), .err = take(".err")};
}

}  // namespace dvdx::test
