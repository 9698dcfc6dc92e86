// Files and directories that must not outlive the program, whether it returns, throws or is ended by a signal.
#pragma once

#include <csignal>
#include <filesystem>
#include <memory>

namespace dvdx::tool {

// From now on a signal that ends the program (SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGXCPU) first removes every
// Temporary, then has its default effect, so that the exit status is the signal's. A signal that the program was started to
// ignore stays ignored. A write beyond the limit on file sizes fails instead of ending the program (SIGXFSZ). Call it on the
// thread that makes the Temporaries, before any other thread starts.
void remove_temporaries_on_signals();

// One thread makes, keeps and destroys all of them. Any thread may spare one.
class Temporary {
 public:
  enum class Kind { file, directory };

  // Construct it before anything is at `path`, so that nothing that the program makes there goes unnoticed.
  explicit Temporary(std::filesystem::path path, Kind kind = Kind::file);
  Temporary(Temporary&&) noexcept;
  Temporary& operator=(Temporary&&) = delete;
  ~Temporary();  // removes the file at the path, or the directory if it is empty

  [[nodiscard]] const std::filesystem::path& path() const noexcept;
  void keep() noexcept;  // what is at the path now stays
  // The same from any thread, while the owning thread neither keeps nor destroys it. keep() may follow.
  void spare() const noexcept;

  struct Entry;  // of the list that the signal handler walks

 private:
  std::unique_ptr<Entry> entry_;  // none once kept or moved from
};

// Holds the signals above back while it lives: the guarded work happens as a whole or not at all.
class SignalsHeld {
 public:
  SignalsHeld();
  SignalsHeld(const SignalsHeld&) = delete;
  SignalsHeld& operator=(const SignalsHeld&) = delete;
  ~SignalsHeld();

 private:
  sigset_t before_{};
};

}  // namespace dvdx::tool
