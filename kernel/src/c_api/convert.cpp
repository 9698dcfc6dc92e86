#include "c_api/convert.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "c_api/guard.hpp"
#include "c_api/overlap.hpp"

namespace dvdx::c_api {
namespace {

constexpr int precisions = 2, isas = 6, arithmetics = 3, roundings = 2;

}  // namespace

template <class T>
dvdx_status check_column(const dvdx_column& c, const char* name, dvdx_error* error) noexcept {
  const auto fail = [&](const char* value, const char* valid) { return report(error, DVDX_INVALID, name, value, valid); };
  if (c.base == nullptr) return fail("a null pointer", "memory of the caller's");
  if (reinterpret_cast<std::uintptr_t>(c.base) % alignof(T) != 0) return fail("not aligned", "aligned as its type");
  if (c.run == 0) return DVDX_DONE;
  if (!std::has_single_bit(c.run)) return fail("in runs of no power of two", "0, or elements side by side, a power of two");
  if (c.stride % static_cast<std::ptrdiff_t>(alignof(T)) != 0) return fail("of an odd stride", "aligned in each run");
  return DVDX_DONE;
}

template <class T>
dvdx_status check_columns(const dvdx_state& state, std::size_t needed, dvdx_error* error) noexcept {
  constexpr std::array names = {"x[0]", "x[1]", "x[2]", "v[0]", "v[1]", "v[2]"};
  constexpr std::array rests = {"x_rest[0]", "x_rest[1]", "x_rest[2]", "v_rest[0]", "v_rest[1]", "v_rest[2]"};
  const int precision = number_of(state.precision);
  if (precision < 0 || precision >= precisions) {
    return report(error, DVDX_INVALID, "state.precision", "no precision", "DVDX_FLOAT32 or DVDX_FLOAT64");
  }
  if (precision != (sizeof(T) == sizeof(float) ? DVDX_FLOAT32 : DVDX_FLOAT64)) return report(error, DVDX_PRECISION_DIFFERS);
  if (needed == 0) return DVDX_DONE;
  std::array<NamedColumn, 12> columns{};
  std::size_t count = 0;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const dvdx_column& c = k < 3 ? state.x[k] : state.v[k - 3];
    if (const dvdx_status status = check_column<T>(c, names[k], error); status != DVDX_DONE) return status;
    columns[count++] = {&c, names[k]};
    const dvdx_column& rest = k < 3 ? state.x_rest[k] : state.v_rest[k - 3];
    if (rest.capacity == 0) continue;  // there is none
    if (const dvdx_status status = check_column<T>(rest, rests[k], error); status != DVDX_DONE) return status;
    columns[count++] = {&rest, rests[k]};
  }
  return check_apart<T>({columns.data(), count}, needed, error);
}

template <class T>
dvdx_status check_apart(std::span<const NamedColumn> columns, std::size_t count, dvdx_error* error) noexcept {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Runs one = runs_of(*columns[i].column, count, sizeof(T));
    if (overlaps_itself(one)) {
      return report(error, DVDX_INVALID, columns[i].name, "a column whose elements share memory", "memory for each element");
    }
    for (std::size_t k = 0; k < i; ++k) {
      if (!overlap(one, runs_of(*columns[k].column, count, sizeof(T)))) continue;
      return report(error, DVDX_INVALID, columns[i].name, columns[k].name, "memory of its own: the two columns overlap");
    }
  }
  return DVDX_DONE;
}

template dvdx_status check_column<float>(const dvdx_column&, const char*, dvdx_error*) noexcept;
template dvdx_status check_column<double>(const dvdx_column&, const char*, dvdx_error*) noexcept;
template dvdx_status check_apart<float>(std::span<const NamedColumn>, std::size_t, dvdx_error*) noexcept;
template dvdx_status check_apart<double>(std::span<const NamedColumn>, std::size_t, dvdx_error*) noexcept;
template dvdx_status check_columns<float>(const dvdx_state&, std::size_t, dvdx_error*) noexcept;
template dvdx_status check_columns<double>(const dvdx_state&, std::size_t, dvdx_error*) noexcept;

namespace {

dvdx_status status_of(StepResult result) noexcept {
  switch (result) {
    case StepResult::done:
      return DVDX_DONE;
    case StepResult::count_differs:
      return DVDX_COUNT_DIFFERS;
    case StepResult::capacity_too_small:
      return DVDX_CAPACITY_TOO_SMALL;
    case StepResult::in_use:
      return DVDX_IN_USE;
    case StepResult::workspace_differs:
      return DVDX_WORKSPACE_DIFFERS;
    case StepResult::report_differs:
      return DVDX_REPORT_DIFFERS;
    case StepResult::time_not_finite:
      return DVDX_INVALID;
    case StepResult::too_many_neighbours:
      return DVDX_TOO_MANY_NEIGHBOURS;
    case StepResult::driven_elsewhere:
      return DVDX_DRIVEN_ELSEWHERE;
    case StepResult::moved_from:
      return DVDX_FAILED;
  }
  return DVDX_FAILED;
}

// The word for a number that is not finite, in static memory.
const char* words_of(double number) noexcept { return std::isnan(number) ? "nan" : number > 0 ? "inf" : "-inf"; }

}  // namespace

dvdx_status report(dvdx_error* error, StepResult result, const dvdx_clock& clock) noexcept {
  if (result != StepResult::time_not_finite) return report(error, status_of(result));
  const double wrong = std::isfinite(clock.seconds) ? clock.carry : clock.seconds;
  return report(error, DVDX_INVALID, "state.clock", words_of(wrong), "a finite time");
}

void put_check(const StateCheck& found, dvdx_state_check& check) noexcept {
  check = {.stretch = found.stretch,
           .network = found.network,
           .spring = {found.spring[0], found.spring[1]},
           .off = found.off,
           .constraint = found.constraint,
           .rod = {found.rod[0], found.rod[1]},
           .kinetic = found.kinetic,
           .elastic = found.elastic,
           .weight = found.weight,
           .not_finite = found.not_finite,
           .first_not_finite = found.first_not_finite};
}

Options options_of(const dvdx_options& from) {
  Options to;
  to.step = from.step;
  const auto isa = choice<dvdx_isa>(from.isa, isas, "isa");
  if (isa != DVDX_ISA_BEST) to.isa = static_cast<Isa>(static_cast<int>(isa) - 1);
  to.arithmetic = choice<Arithmetic>(from.arithmetic, arithmetics, "arithmetic");
  to.block = from.block;
  to.rounding = choice<Rounding>(from.rounding, roundings, "rounding");
  if (from.impacts != 0) to.impacts = from.impacts;
  if (from.allocator.allocate != nullptr && from.allocator.release == nullptr) {
    throw Error{"allocator.release", "null", "a function, where allocator.allocate is one"};
  }
  to.memory = {.allocate = from.allocator.allocate, .release = from.allocator.release, .context = from.allocator.context};
  return to;
}

dvdx_precision precision_of(const dvdx_options& from) {
  return choice<dvdx_precision>(from.precision, precisions, "precision");
}

}  // namespace dvdx::c_api
