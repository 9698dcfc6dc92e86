#include "checkpoint/checkpoint_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "checkpoint/written_together.hpp"
#include "files/descriptor.hpp"
#include "ranks/agree.hpp"
#include "scene_io/fault.hpp"

namespace dvdx::tool {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::string_view first_bytes = "dvdx-checkpoint\n";
constexpr std::uint32_t checkpoint_format = 2;
constexpr std::uint32_t most_header = std::uint32_t{1} << 20U;         // bytes
constexpr std::uint64_t front_bytes = 16 + 3 * sizeof(std::uint32_t);  // first_bytes, format, bytes of the header, their CRC
constexpr std::uint64_t end_bytes = sizeof(std::uint64_t) + sizeof(std::uint32_t);  // bytes of the data, their CRC

class Counting final : public Sink {
 public:
  void write(std::string_view some) override { bytes += some.size(); }
  std::uint64_t bytes = 0;
};

class ToText final : public Sink {
 public:
  void write(std::string_view some) override { text += some; }
  std::string text;
};

Json json_of(const KeptMark& mark) { return {{"file", mark.file}, {"bytes", mark.bytes}, {"crc", mark.crc}}; }
KeptMark kept_mark_of(const Json& json) { return {.file = json.at("file"), .bytes = json.at("bytes"), .crc = json.at("crc")}; }

std::string head_text(const CheckpointHeader& header) {
  Json json{{"dvdx", header.run.version},
            {"precision", header.run.precision},
            {"arithmetic", header.run.arithmetic},
            {"scene", header.run.scene},
            {"name", header.name},
            {"step", header.step},
            {"states", nullptr},
            {"events", nullptr}};
  if (header.states) {
    const auto& states = *header.states;
    json["states"] = json_of(states.kept);
    json["states"]["every"] = states.every;
    json["states"]["count"] = states.count;
  }
  if (header.events) json["events"] = json_of(*header.events);
  return json.dump();
}

CheckpointHeader header_of(std::string_view text) {
  const Json json = Json::parse(text);
  CheckpointHeader header{.run = {.version = json.at("dvdx"),
                                  .precision = json.at("precision"),
                                  .arithmetic = json.at("arithmetic"),
                                  .scene = json.at("scene")},
                          .name = json.at("name"),
                          .step = json.at("step")};
  if (const auto& states = json.at("states"); !states.is_null()) {
    header.states = {.kept = kept_mark_of(states), .every = states.at("every"), .count = states.at("count")};
  }
  if (const auto& events = json.at("events"); !events.is_null()) header.events = kept_mark_of(events);
  return header;
}

void write_head(Sink& sink, const std::string& text) {
  ToText start;
  start.write(first_bytes);
  start.put(checkpoint_format);
  start.put(static_cast<std::uint32_t>(text.size()));
  const auto crc = crc_of(text, crc_of(start.text));
  sink.write(start.text);
  sink.put(crc);
  sink.write(text);
}

[[noreturn]] void refuse(const fs::path& file, const std::string& what) {
  throw Fault(Exit::input_output, file.string() + ": " + what);
}

// The header, and the byte at which the data begin.
struct Head {
  CheckpointHeader header;
  std::uint64_t data = 0;
};

Head head_of(const fs::path& file, std::uint64_t size) {
  if (size < front_bytes + end_bytes) refuse(file, fmt::format("is no checkpoint: it has {} bytes", size));
  FileSource source(file, 0, size);
  std::string start(first_bytes.size() + 2 * sizeof(std::uint32_t), '\0');
  source.read(start.data(), start.size());
  if (!start.starts_with(first_bytes)) refuse(file, "is no checkpoint: it does not start like one, or is damaged");
  std::uint32_t written_format = 0;
  std::uint32_t length = 0;
  std::memcpy(&written_format, start.data() + first_bytes.size(), sizeof(written_format));
  std::memcpy(&length, start.data() + first_bytes.size() + sizeof(written_format), sizeof(length));
  const auto crc = source.get<std::uint32_t>();
  if (length > most_header || length > source.left()) refuse(file, "is damaged: its head is not whole");
  std::string text(length, '\0');
  source.read(text.data(), text.size());
  if (crc != crc_of(text, crc_of(start))) refuse(file, "is damaged: its head is not what was written");
  if (written_format != checkpoint_format) {
    throw Fault(Exit::bad_scene, fmt::format("{}: is a checkpoint of format {}: must be {}, which this dvdx writes",
                                             file.string(), written_format, checkpoint_format));
  }
  try {
    return {.header = header_of(text), .data = front_bytes + length};
  } catch (const nlohmann::json::exception&) {
    refuse(file, "is damaged: its head lacks something");
  }
}

std::uint64_t size_of(const fs::path& file) {
  std::error_code error;
  if (fs::exists(file, error) && !fs::is_regular_file(file, error)) refuse(file, "cannot be read: it is no plain file");
  const auto size = fs::file_size(file, error);
  if (error) refuse(file, "cannot be read: " + error.message());
  return size;
}

void check_same(const fs::path& file, std::string_view what, const std::string& theirs, const std::string& ours) {
  if (theirs == ours) return;
  throw Fault(Exit::bad_scene, fmt::format("{}: is a checkpoint of {} {}, and this run has {}: must be the same", file.string(),
                                           what, theirs, ours));
}

void put_in_place(const fs::path& part, const fs::path& file) {
  std::error_code error;
  fs::rename(part, file, error);
  if (error) refuse_to_write(file, error.value());
  sync_folder_of(file);
}

}  // namespace

std::optional<std::string> checkpoint_text(const CheckpointHeader& header, const SaveRun& save, std::uint64_t most) {
  Counting counting;
  save(counting);
  if (counting.bytes > most) return std::nullopt;
  ToText whole;
  whole.text.reserve(counting.bytes + most_header);
  write_head(whole, head_text(header));
  const std::size_t head = whole.text.size();
  save(whole);
  const std::uint32_t crc = crc_of(std::string_view(whole.text).substr(head));
  whole.put<std::uint64_t>(whole.text.size() - head);
  whole.put(crc);
  return std::move(whole.text);
}

void write_checkpoint(const fs::path& file, const fs::path& part, std::string_view text,
                      const std::function<void()>& before_renamed) {
  {
    const Descriptor descriptor(part, O_TRUNC);
    write_all_at(descriptor.number(), file, 0, text);
    sync_file(descriptor.number(), file);
  }
  before_renamed();
  put_in_place(part, file);
}

void write_checkpoint(Ranks& ranks, const fs::path& file, const fs::path& part, const CheckpointHeader& header,
                      const SaveRun& save, const std::function<void()>& before_renamed) {
  std::string text = head_text(header);
  std::uint64_t size = text.size();
  ranks.broadcast(0, writable_bytes_in(size));
  text.resize(size);
  ranks.broadcast(0, std::as_writable_bytes(std::span(text)));
  std::optional<Descriptor> descriptor;
  const bool is_first = ranks.rank() == 0;
  together(ranks, [&] {
    if (is_first) descriptor.emplace(part, O_TRUNC);
  });
  together(ranks, [&] {
    if (!is_first) descriptor.emplace(part, 0);
  });
  const int number = descriptor->number();
  const Stored head = write_together(ranks, number, file, 0, [&](Sink& sink) { write_head(sink, text); });
  const Stored data = write_together(ranks, number, file, head.bytes, save);
  const auto write_end = [&](Sink& sink) {
    sink.put(data.bytes);
    sink.put(data.crc);
  };
  (void)write_together(ranks, number, file, head.bytes + data.bytes, write_end);
  together(ranks, [&] { sync_file(number, file); });
  together(ranks, [&] {
    if (!is_first) return;
    before_renamed();
    put_in_place(part, file);
  });
}

std::optional<CheckpointHeader> peek_checkpoint(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return std::nullopt;
  try {
    return head_of(file, size_of(file)).header;
  } catch (const Fault&) {
    return std::nullopt;
  }
}

Checkpoint::Checkpoint(fs::path file, const RunIdentity& run, Look look) : file_(std::move(file)) {
  const auto size = size_of(file_);
  auto head = head_of(file_, size);
  header_ = std::move(head.header);
  data_ = head.data;
  check_same(file_, "dvdx", header_.run.version, run.version);
  check_same(file_, "precision", header_.run.precision, run.precision);
  check_same(file_, "arithmetic", header_.run.arithmetic, run.arithmetic);
  if (header_.run.scene != run.scene) {
    throw Fault(
        Exit::bad_scene,
        fmt::format("{}: is a checkpoint of another scene, \"{}\", or of this one with other values, step, duration, method "
                    "or data files: must be of this very run",
                    file_.string(), header_.name));
  }
  if (size < data_ + end_bytes) refuse(file_, "is damaged: its end is missing");
  bytes_ = size - data_ - end_bytes;
  FileSource end(file_, data_ + bytes_, end_bytes);
  if (end.get<std::uint64_t>() != bytes_) refuse(file_, "is damaged: its end is missing");
  const auto crc = end.get<std::uint32_t>();
  if (look == Look::all && crc != crc_of_file(file_, data_, bytes_)) {
    refuse(file_, "is damaged: its data is not what was written");
  }
}

void Checkpoint::load(const std::function<void(Source&)>& load) const {
  FileSource source(file_, data_, bytes_);
  load(source);
  if (source.left() != 0) source.fail();
}

}  // namespace dvdx::tool
