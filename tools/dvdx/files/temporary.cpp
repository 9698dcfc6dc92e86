#include "files/temporary.hpp"

#include <pthread.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <string>
#include <utility>

namespace dvdx::tool {

struct Temporary::Entry {
  std::filesystem::path path;
  Kind kind;
  std::atomic<bool> is_spared{false};
  std::atomic<Entry*> next{nullptr};
  Entry* previous = nullptr;
};

namespace {

using Entry = Temporary::Entry;

// A handler's view of the program, as it gets no argument. The owning thread alone changes the list, and alone walks it in
// a handler, so a walk sees the list as it is between two stores. Entries that are newer come first: files before their
// directory.
std::atomic<Entry*> newest{nullptr};
pthread_t owning_thread;
static_assert(std::atomic<Entry*>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

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
  for (const Entry* entry = newest.load(); entry != nullptr; entry = entry->next.load()) remove(*entry);
  struct sigaction by_default {};
  by_default.sa_handler = SIG_DFL;
  sigaction(signal, &by_default, nullptr);
  raise(signal);  // blocked until the handler returns
}

void link(Entry& entry) noexcept {
  Entry* const next = newest.load();
  entry.next.store(next);
  if (next != nullptr) next->previous = &entry;
  newest.store(&entry);
}

void unlink_entry(Entry& entry) noexcept {
  Entry* const next = entry.next.load();
  if (next != nullptr) next->previous = entry.previous;
  (entry.previous != nullptr ? entry.previous->next : newest).store(next);
}

}  // namespace

void remove_temporaries_on_signals() {
  owning_thread = pthread_self();
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
  link(*entry_);
}

Temporary::Temporary(Temporary&&) noexcept = default;

Temporary::~Temporary() {
  if (!entry_) return;
  remove(*entry_);
  unlink_entry(*entry_);
}

const std::filesystem::path& Temporary::path() const noexcept { return entry_->path; }

void Temporary::keep() noexcept {
  if (entry_) unlink_entry(*entry_);
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

bool SignalsHeld::is_one_waiting() noexcept {
  sigset_t waiting;
  sigemptyset(&waiting);
  if (sigpending(&waiting) != 0) return false;
  for (const int signal : ending) {
    if (sigismember(&waiting, signal) == 1) return true;
  }
  return false;
}

}  // namespace dvdx::tool
