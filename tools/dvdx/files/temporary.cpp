#include "files/temporary.hpp"

#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <utility>
#include <vector>

namespace dvdx::tool {

struct Temporary::Entry {
  std::filesystem::path path;
  Kind kind;
  std::atomic<bool> is_spared{false};
};

namespace {

using Entry = Temporary::Entry;

// Global, because a signal handler gets no argument. Only the owning thread changes the list, while signals are held, and only
// it walks the list in a handler. Files stand behind their directory. Never destroyed, because a signal may come while the
// program ends.
std::vector<const Entry*>& entries() {
  static auto* const all = new std::vector<const Entry*>;
  return *all;
}
pthread_t owning_thread;
static_assert(std::atomic<bool>::is_always_lock_free);

constexpr std::array ending{SIGHUP, SIGINT, SIGQUIT, SIGPIPE, SIGTERM, SIGXCPU};

sigset_t ending_set() noexcept {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : ending) sigaddset(&set, signal);
  return set;
}

// unlink and rmdir are async-signal-safe, std::filesystem is not.
void remove(const Entry& entry) noexcept {
  if (entry.is_spared.load()) return;
  if (entry.kind == Temporary::Kind::file) {
    unlink(entry.path.c_str());
  } else {
    rmdir(entry.path.c_str());
  }
}

extern "C" void remove_all_and_end(int signal) {
  const int error = errno;
  if (pthread_equal(pthread_self(), owning_thread) == 0) {
    pthread_kill(owning_thread, signal);
    errno = error;
    return;
  }
  std::for_each(entries().rbegin(), entries().rend(), [](const Entry* entry) { remove(*entry); });
  struct sigaction by_default {};
  by_default.sa_handler = SIG_DFL;
  sigaction(signal, &by_default, nullptr);
  raise(signal);  // blocked until the handler returns
}

void forget(const Entry& entry) {
  const SignalsHeld held;
  std::erase(entries(), &entry);
}

}  // namespace

void remove_temporaries_on_signals() {
  owning_thread = pthread_self();
  (void)entries();  // made before a handler asks for it
  struct sigaction action {};
  action.sa_handler = remove_all_and_end;
  action.sa_mask = ending_set();
  action.sa_flags = SA_RESTART;
  for (const int signal : ending) {
    struct sigaction now {};
    if (sigaction(signal, nullptr, &now) == 0 && now.sa_handler != SIG_IGN) sigaction(signal, &action, nullptr);
  }
  std::signal(SIGXFSZ, SIG_IGN);
}

Temporary::Temporary(std::filesystem::path path, Kind kind) : entry_(new Entry{.path = std::move(path), .kind = kind}) {
  const SignalsHeld held;
  entries().push_back(entry_.get());
}

Temporary::Temporary(Temporary&&) noexcept = default;

Temporary::~Temporary() {
  if (!entry_) return;
  remove(*entry_);
  forget(*entry_);
}

const std::filesystem::path& Temporary::path() const noexcept { return entry_->path; }

void Temporary::keep() noexcept {
  if (entry_) forget(*entry_);
  entry_.reset();
}

void Temporary::spare() const noexcept {
  if (entry_) entry_->is_spared.store(true);
}

SignalsHeld::SignalsHeld() {
  const auto set = ending_set();
  pthread_sigmask(SIG_BLOCK, &set, &before_);
}

SignalsHeld::~SignalsHeld() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

}  // namespace dvdx::tool
