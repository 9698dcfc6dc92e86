// The border between C++ and C: errors go into the caller's memory, and no exception goes further.
#pragma once

#include <cstddef>
#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <string_view>

#include "dvdx/dvdx.h"
#include "dvdx/fields.hpp"
#include "dvdx/plan.hpp"

namespace dvdx::c_api {

// Texts in `error` that do not fit are cut. None of these allocates; error may be null.
dvdx_status report(dvdx_error* error, dvdx_status status) noexcept;
dvdx_status report(dvdx_error* error, dvdx_status status, std::string_view field, std::string_view value,
                   std::string_view valid) noexcept;
dvdx_status report(dvdx_error* error, const Error& fault) noexcept;
dvdx_status failed(dvdx_error* error, const char* what) noexcept;

// Reports a null pointer that must not be null.
inline dvdx_status missing(dvdx_error* error, std::string_view argument) noexcept {
  return report(error, DVDX_INVALID, argument, "null", "a pointer to what the name says");
}

// Throws Error if a null pointer comes with elements, or if `count` is more than there can be particles.
inline void need(const void* pointer, std::size_t count, const std::string& field) {
  if (count > 0xffffffff) throw Error{field, std::to_string(count) + " elements", "at most 4294967295 elements"};
  if (pointer == nullptr && count != 0) throw Error{field, "null", "a pointer to " + std::to_string(count) + " elements"};
}

// Returns the status of `work`, or that of the exception that it throws.
template <class Work>
dvdx_status guarded(dvdx_error* error, const Work& work) noexcept {
  try {
    return work();
  } catch (const Error& fault) {
    return report(error, fault);
  } catch (const std::bad_alloc&) {
    return report(error, DVDX_OUT_OF_MEMORY);
  } catch (const std::exception& fault) {
    return failed(error, fault.what());
  } catch (...) {
    return failed(error, "an exception of an unknown type");
  }
}

inline dvdx_status done_or(dvdx_error* error, const Expected<void>& result) noexcept {
  return result ? report(error, DVDX_DONE) : report(error, result.error());
}

// Copies as many bytes of text as fit, ended by a zero. Returns the length of all of it.
std::size_t copy_text(std::string_view text, char* to, std::size_t capacity) noexcept;

inline Vec3 vec3(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

// choice() converts a choice of C to one of C++ whose enumerators count in the same order. It throws Error if it is none of
// the `count`. The number is read as bytes: a caller may have written anything.
template <class From>
int number_of(const From& from) noexcept {
  static_assert(sizeof(From) == sizeof(int));
  int value = 0;
  std::memcpy(&value, &from, sizeof value);
  return value;
}

template <class To, class From>
To choice(const From& from, int count, const std::string& field) {
  const int value = number_of(from);
  if (value >= 0 && value < count) return static_cast<To>(value);
  throw Error{field, std::to_string(value), "a choice from 0 to " + std::to_string(count - 1)};
}
// A choice that scene files have words for.
template <class To, class From>
To choice(const From& from, const std::string& field) {
  return choice<To>(from, static_cast<int>(words<To>.size()), field);
}

}  // namespace dvdx::c_api
