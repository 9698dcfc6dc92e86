// The reason why a command ends early: a message for the user and the exit code that goes with it.
#pragma once

#include <stdexcept>
#include <string>

namespace dvdx::tool {

enum class Exit : int {
  done = 0,
  verification_failed = 1,
  usage = 2,
  bad_scene = 3,
  input_output = 4,
  diverged = 5,
  warned = 6,  // of a run that is asked to be strict
};

class Fault : public std::runtime_error {
 public:
  Fault(Exit exit, const std::string& message) : std::runtime_error(message), exit_(exit) {}
  [[nodiscard]] Exit exit() const noexcept { return exit_; }

 private:
  Exit exit_;
};

}  // namespace dvdx::tool
