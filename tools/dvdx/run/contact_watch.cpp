#include "run/contact_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include "dvdx/plan.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {
namespace {

constexpr std::size_t chunk = 1 << 20;  // bytes of text
// Events: what a step may hold at most, but for one in which hundreds of impacts of each particle follow one another.
constexpr std::size_t least_room = std::size_t{1} << 16U;
constexpr std::size_t most_room = std::size_t{1} << 24U;
constexpr std::size_t events_each = 256;

}  // namespace

ContactWatch::ContactWatch(const SceneFile& file, Sums sums, const std::filesystem::path& events)
    : contacts_(file.scene.contacts.size()) {
  if (events.empty()) {
    if (sums == Sums::counted && contacts_ != 0) report_.emplace(contacts_);
    return;
  }
  if (events.extension() != ".csv") throw Fault(Exit::usage, "--events " + events.string() + ": must end in .csv");
  check_is_no_source(events, file.sources, events, "--events");
  file_.emplace(events);
  text_ = "step,time,particle,contact,x,y,z,nx,ny,nz,impulse\n";
  if (contacts_ == 0) return;
  const std::size_t in_step = std::max<std::size_t>(1, std::max(file.particles.count, file.turnover.capacity)) * events_each;
  const std::size_t count = std::clamp(in_step, least_room, most_room);
  steps_in_room_ = std::max<std::uint64_t>(1, count / in_step);
  room_ = std::make_unique_for_overwrite<std::byte[]>(count * sizeof(ContactEvent));
  report_.emplace(contacts_, std::span(reinterpret_cast<ContactEvent*>(room_.get()), count));
}

std::uint64_t ContactWatch::most_steps(std::uint64_t wanted) const noexcept {
  return steps_in_room_ == 0 ? wanted : std::min(wanted, steps_in_room_);
}

void ContactWatch::write() {
  if (!file_ || !report_) return;
  if (report_->lost() != 0) {
    throw Fault(Exit::input_output, fmt::format("{}: step {} has {} impacts more than there is room for: a shorter --step has "
                                                "fewer",
                                                file_->target().string(), report_->steps(), report_->lost()));
  }
  for (const ContactEvent& event : report_->events()) {
    const auto& [x, y, z] = event.x;
    const auto& [nx, ny, nz] = event.n;
    const Vec3& p = event.impulse;
    const double size = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    fmt::format_to(std::back_inserter(text_), "{},{},{},{},{},{},{},{},{},{},{}\n", event.step, event.time, event.particle,
                   event.contact, x, y, z, nx, ny, nz, size);
    if (text_.size() > chunk) flush();
  }
  report_->clear_events();
}

void ContactWatch::flush() {
  file_->write(text_);
  text_.clear();
}

void ContactWatch::finish() {
  if (!file_) return;
  flush();
  file_->commit();
}

void ContactWatch::save(Sink& sink) const { sink.put(report_ ? report_->words() : std::span<const std::int64_t>()); }

void ContactWatch::load(Source& source) {
  std::vector<std::int64_t> words;
  source.get(words);
  if (!report_) return;
  if (words.size() != report_->words().size()) source.fail();
  report_->add(words);
}

void ContactWatch::join(Ranks& ranks) {
  if (!report_ || ranks.count() == 1) return;
  const auto mine = report_->words();
  std::vector<std::uint64_t> all(mine.begin(), mine.end());
  ranks.sum(all);
  report_->clear();
  report_->add(std::vector<std::int64_t>(all.begin(), all.end()));
}

std::vector<ContactSum> ContactWatch::sums() const {
  std::vector<ContactSum> sums;
  for (std::size_t j = 0; report_ && j < contacts_; ++j) sums.push_back(report_->of(j));
  return sums;
}

}  // namespace dvdx::tool
