// Reports of contacts by C.
#include "dvdx/contact_report.hpp"

#include <cstddef>
#include <type_traits>

#include "c_api/contact_report.hpp"
#include "c_api/guard.hpp"

using namespace dvdx::c_api;
using dvdx::ContactEvent;

// Events are written into the caller's memory: both types of an event have one layout.
static_assert(std::is_standard_layout_v<ContactEvent> && sizeof(ContactEvent) == sizeof(dvdx_contact_event));
static_assert(offsetof(ContactEvent, time) == offsetof(dvdx_contact_event, time) &&
              offsetof(ContactEvent, particle) == offsetof(dvdx_contact_event, particle) &&
              offsetof(ContactEvent, contact) == offsetof(dvdx_contact_event, contact) &&
              offsetof(ContactEvent, x) == offsetof(dvdx_contact_event, x) &&
              offsetof(ContactEvent, n) == offsetof(dvdx_contact_event, n) &&
              offsetof(ContactEvent, impulse) == offsetof(dvdx_contact_event, impulse));

dvdx_status dvdx_contact_report_create(size_t contacts, dvdx_contact_event* room, size_t capacity, dvdx_contact_report** report,
                                       dvdx_error* error) {
  if (report == nullptr) return missing(error, "report");
  *report = nullptr;
  if (room == nullptr && capacity != 0) return missing(error, "room");
  return guarded(error, [&] {
    *report = new dvdx_contact_report{dvdx::ContactReport(contacts, {reinterpret_cast<ContactEvent*>(room), capacity})};
    return dvdx::c_api::report(error, DVDX_DONE);
  });
}

void dvdx_contact_report_destroy(dvdx_contact_report* report) { delete report; }

dvdx_status dvdx_contact_report_sum(const dvdx_contact_report* report, size_t contact, dvdx_contact_sum* sum,
                                    dvdx_error* error) {
  if (report == nullptr) return missing(error, "report");
  if (sum == nullptr) return missing(error, "sum");
  return guarded(error, [&] {
    const std::size_t contacts = report->report.contacts();
    if (contact >= contacts) {
      throw dvdx::Error{"contact", std::to_string(contact), "below the report's " + std::to_string(contacts) + " contacts"};
    }
    const dvdx::ContactSum of = report->report.of(contact);
    sum->hits = of.hits;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sum->impulse[axis] = of.impulse[axis];
      sum->torque_impulse[axis] = of.torque_impulse[axis];
    }
    return dvdx::c_api::report(error, DVDX_DONE);
  });
}

size_t dvdx_contact_report_events(const dvdx_contact_report* report) {
  return report == nullptr ? 0 : report->report.events().size();
}
uint64_t dvdx_contact_report_lost(const dvdx_contact_report* report) { return report == nullptr ? 0 : report->report.lost(); }
void dvdx_contact_report_clear(dvdx_contact_report* report) {
  if (report != nullptr) report->report.clear();
}
void dvdx_contact_report_clear_events(dvdx_contact_report* report) {
  if (report != nullptr) report->report.clear_events();
}
