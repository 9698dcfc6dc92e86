// Files and directories that must not outlive the program, whether it returns, throws or is ended by a signal.
#pragma once

#include <csignal>
#include <filesystem>
#include <memory>

namespace dvdx::tool {

// From now on a signal that ends the program (SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGXCPU) first removes every
// Temporary, then has its default effect, so that the exit status is the signal's. One that the program was started to ignore
// stays ignored. A file that reaches the limit on file sizes makes its write fail instead of ending the program (SIGXFSZ). To
// be called on the thread that makes the Temporaries, before any other thread starts.
void remove_temporaries_on_signals();

// All are made, kept and destroyed on one thread; any may spare one.
class Temporary {
 public:
  enum class Kind { file, directory };

  // To be constructed before anything is at `path`: nothing that the program makes there goes unnoticed.
  explicit Temporary(std::filesystem::path path, Kind kind = Kind::file);
  Temporary(Temporary&&) noexcept;
  Temporary& operator=(Temporary&&) = delete;
  ~Temporary();  // removes what is at the path; a directory only where it is empty

  [[nodiscard]] const std::filesystem::path& path() const noexcept;
  void keep() noexcept;  // what is at the path now stays
  // The same from any thread, while the owner's neither keeps nor destroys it; keep() may follow.
  void spare() const noexcept;

  struct Entry;  // of the list that the signal handler walks

 private:
  std::unique_ptr<Entry> entry_;  // none once kept or moved from
};

// While one lives, the signals above wait: what it guards happens as a whole or not at all.
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
