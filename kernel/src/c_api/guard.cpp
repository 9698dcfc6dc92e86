#include "c_api/guard.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace dvdx::c_api {
namespace {

constexpr std::array texts = {"done",
                              "a value is out of its range",
                              "out of memory",
                              "the plan holds values for each particle, and the state has another count",
                              "a column's capacity is below the state's count",
                              "another thread steps this plan, or in this workspace: each serves one state at a time",
                              "the state's numbers are of another type than the plan's",
                              "compiled for another version of the library",
                              "failed for an unknown reason",
                              "the report is for another number of contacts than the plan's scene has",
                              "the workspace was made for another scene or precision",
                              "the plan was told where something goes, and the workspace was not: tell the workspace"};

const char* text_of(dvdx_status status) noexcept {
  const auto i = static_cast<std::size_t>(status);
  return i < texts.size() ? texts[i] : "no status of dvdx";
}

template <std::size_t N>
void put(char (&to)[N], std::string_view text) noexcept {
  copy_text(text, &to[0], N);
}

}  // namespace

std::size_t copy_text(std::string_view text, char* to, std::size_t capacity) noexcept {
  if (capacity != 0) {
    const std::size_t fits = std::min(text.size(), capacity - 1);
    std::memcpy(to, text.data(), fits);
    to[fits] = '\0';
  }
  return text.size();
}

dvdx_status report(dvdx_error* error, dvdx_status status) noexcept {
  if (error == nullptr) return status;
  error->status = status;
  put(error->field, "");
  put(error->value, "");
  put(error->valid, "");
  put(error->message, status == DVDX_DONE ? "" : text_of(status));
  return status;
}

dvdx_status report(dvdx_error* error, dvdx_status status, std::string_view field, std::string_view value,
                   std::string_view valid) noexcept {
  if (error == nullptr) return status;
  error->status = status;
  put(error->field, field);
  put(error->value, value);
  put(error->valid, valid);
  // The message is cut to the part of the sentence that fits.
  std::size_t end = 0;
  for (const std::string_view part :
       {std::string_view(&error->field[0]), std::string_view(" is "), std::string_view(&error->value[0]),
        std::string_view(": must be "), std::string_view(&error->valid[0])}) {
    end += copy_text(part, &error->message[end], sizeof error->message - end);
    end = std::min(end, sizeof error->message - 1);
  }
  return status;
}

dvdx_status report(dvdx_error* error, const Error& fault) noexcept {
  return report(error, DVDX_INVALID, fault.field, fault.value, fault.valid);
}

dvdx_status failed(dvdx_error* error, const char* what) noexcept {
  report(error, DVDX_FAILED);
  if (error != nullptr) put(error->message, what);
  return DVDX_FAILED;
}

}  // namespace dvdx::c_api

const char* dvdx_status_text(dvdx_status status) { return dvdx::c_api::text_of(status); }
