// The handle of a report.
#pragma once

#include "dvdx/contact_report.hpp"
#include "dvdx/dvdx.h"

struct dvdx_contact_report {
  dvdx::ContactReport report;
};
