#include "watch/contact_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <span>
#include <utility>

#include "dvdx/plan.hpp"
#include "files/part_name.hpp"
#include "ranks/agree.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {
namespace {

constexpr std::size_t chunk = 1 << 20;  // bytes of text
// Room for events: enough for a step, unless hundreds of impacts of each particle follow one another in it.
constexpr std::size_t least_room = std::size_t{1} << 16U;
constexpr std::size_t most_room = std::size_t{1} << 24U;
constexpr std::size_t events_each = 256;

}  // namespace

ContactWatch::ContactWatch(const SceneFile& file, Sums sums, const std::filesystem::path& events, Checkpoints& checkpoints,
                           Ranks& ranks)
    : ranks_(ranks),
      contacts_(file.scene.contacts.size()),
      first_(file.particles.first),
      numbering_(file.numbering),
      events_(events) {
  if (events_.empty()) {
    if (sums == Sums::counted && contacts_ != 0) report_.emplace(contacts_);
    return;
  }
  together(ranks_, [&] { open_events(file, checkpoints); });
  if (contacts_ == 0) return;
  const std::size_t in_step = std::max<std::size_t>(1, std::max(file.particles.total(), file.turnover.capacity)) * events_each;
  const std::size_t count = std::clamp(in_step, least_room, most_room);
  steps_in_room_ = std::max<std::uint64_t>(1, count / in_step);
  room_ = std::make_unique_for_overwrite<std::byte[]>(count * sizeof(ContactEvent));
  report_.emplace(contacts_, std::span(reinterpret_cast<ContactEvent*>(room_.get()), count));
}

// A run that writes checkpoints keeps its events beside its checkpoint, and writes them all when it ends.
void ContactWatch::open_events(const SceneFile& file, Checkpoints& checkpoints) {
  if (events_.extension() != ".csv") throw Fault(Exit::usage, "--events " + events_.string() + ": must end in .csv");
  if (ranks_.rank() != 0) return;
  check_is_no_source(events_, file.sources, events_, "--events");
  const Checkpoint* const resumed = checkpoints.resumed();
  if (resumed != nullptr) {
    const auto& header = resumed->header();
    if (!header.events) {
      throw Fault(Exit::usage, fmt::format("--events {}: {} has none of the impacts up to step {}", events_.string(),
                                           resumed->file().string(), header.step));
    }
    check_kept(checkpoints.resumed_events(), *header.events);
  }
  remove_stale_parts(events_.parent_path());
  file_.emplace(events_);  // reports a bad target before the first step
  if (resumed == nullptr) text_ = "step,time,particle,contact,x,y,z,nx,ny,nz,impulse\n";
  if (checkpoints.is_writing()) {
    file_.reset();
    checkpoints.keep_events();
    kept_ = checkpoints.events();
  } else if (resumed != nullptr) {
    for_each_kept_piece(checkpoints.resumed_events(), *resumed->header().events,
                        [this](std::string_view some) { file_->write(some); });
  }
}

std::uint64_t ContactWatch::most_steps(std::uint64_t wanted) const noexcept {
  return steps_in_room_ == 0 ? wanted : std::min(wanted, steps_in_room_);
}

void ContactWatch::check_lost() {
  if (report_->lost() == 0) return;
  throw Fault(Exit::input_output, fmt::format("{}: step {} has {} impacts more than there is room for: a shorter --step has "
                                              "fewer",
                                              events_.string(), report_->steps(), report_->lost()));
}

// Names particles by the scene's numbers. All ranks together find a number's index among all: each counts its own below it.
void ContactWatch::name_particles(std::span<const std::uint64_t> events_of_ranks) {
  if (!numbers_) {
    for (ContactEvent& event : gathered_) {
      event.particle = particles_.empty() ? first_ + event.particle : particles_[event.particle];
    }
    return;
  }
  const auto before = events_of_ranks.begin() + ranks_.rank();
  const auto first = std::accumulate(events_of_ranks.begin(), before, std::uint64_t{0});
  std::vector<std::uint64_t> all(std::accumulate(before, events_of_ranks.end(), first), 0);
  for (std::size_t k = 0; k < gathered_.size(); ++k) {
    all[first + k] = static_cast<std::uint64_t>((*numbers_)[gathered_[k].particle]);
  }
  ranks_.sum(all);  // the other ranks have added zeros
  for (std::uint64_t& number : all) {
    const auto found = std::lower_bound(numbers_->begin(), numbers_->end(), static_cast<std::int64_t>(number));
    number = static_cast<std::uint64_t>(found - numbers_->begin());
  }
  ranks_.sum(all);
  for (std::size_t k = 0; k < gathered_.size(); ++k) gathered_[k].particle = all[first + k];
}

// Returns all events in the order of step and particle. The events of a particle are on one rank, in the order of time.
std::span<const ContactEvent> ContactWatch::gathered() {
  const auto mine = report_->events();
  if (ranks_.count() == 1) return mine;
  gathered_.assign(mine.begin(), mine.end());
  std::vector<std::uint64_t> sizes(static_cast<std::size_t>(ranks_.count()), 0);
  sizes[static_cast<std::size_t>(ranks_.rank())] = gathered_.size();
  ranks_.sum(sizes);
  name_particles(sizes);
  if (ranks_.rank() != 0) {
    if (!gathered_.empty()) ranks_.send(0, std::as_bytes(std::span(gathered_)));
    return {};
  }
  for (std::size_t rank = 1; rank < sizes.size(); ++rank) {
    if (sizes[rank] == 0) continue;
    const std::size_t before = gathered_.size();
    gathered_.resize(before + sizes[rank]);
    ranks_.receive(static_cast<int>(rank), std::as_writable_bytes(std::span(gathered_).subspan(before)));
  }
  std::stable_sort(gathered_.begin(), gathered_.end(), [](const ContactEvent& a, const ContactEvent& b) {
    return std::pair(a.step, a.particle) < std::pair(b.step, b.particle);
  });
  return gathered_;
}

void ContactWatch::write() {
  if (events_.empty() || !report_) return;
  together(ranks_, [this] { check_lost(); });
  for (const ContactEvent& event : gathered()) {
    const auto& [x, y, z] = event.x;
    const auto& [nx, ny, nz] = event.n;
    const Vec3& p = event.impulse;
    const double size = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    fmt::format_to(std::back_inserter(text_), "{},{},{},{},{},{},{},{},{},{},{}\n", event.step, event.time,
                   numbering_.number_of(event.particle), event.contact, x, y, z, nx, ny, nz, size);
    if (text_.size() > chunk) flush();
  }
  report_->clear_events();
}

void ContactWatch::flush() {
  if (kept_ != nullptr) {
    kept_->append(text_);
  } else if (file_) {
    file_->write(text_);
  }
  text_.clear();
}

void ContactWatch::finish() {
  flush();
  if (kept_ != nullptr) {
    file_.emplace(events_);
    for_each_kept_piece(kept_->path(), kept_->mark(), [this](std::string_view some) { file_->write(some); });
  }
  if (file_) file_->commit();
}

std::vector<std::int64_t> ContactWatch::words() {
  if (!report_) return {};
  const auto mine = report_->words();
  std::vector<std::uint64_t> all(mine.begin(), mine.end());
  ranks_.sum(all);
  return {all.begin(), all.end()};
}

void ContactWatch::load(std::span<const std::int64_t> words, std::uint64_t done, Source& source) {
  if (!report_) return;
  report_->set_steps(done);
  if (words.size() != report_->words().size()) source.fail();
  if (ranks_.rank() == 0) report_->add(words);
}

void ContactWatch::join() {
  if (!report_ || ranks_.count() == 1) return;
  const auto all = words();
  report_->clear();
  report_->add(all);
}

std::vector<ContactSum> ContactWatch::sums() const {
  std::vector<ContactSum> sums;
  for (std::size_t j = 0; report_ && j < contacts_; ++j) sums.push_back(report_->of(j));
  return sums;
}

}  // namespace dvdx::tool
