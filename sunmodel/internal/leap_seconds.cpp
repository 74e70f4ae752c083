#include "sunmodel/internal/leap_seconds.h"

#include <algorithm>
#include <stdexcept>

#include <erfa.h>

namespace pleinair {
namespace {

double TableEntryS(std::chrono::sys_days day) {
  const std::chrono::year_month_day date(day);
  double tai_minus_utc_s = 0.0;
  // Status 1 (more than five years after the library's release) still returns the last entry.
  const int status = eraDat(int(date.year()),
                            int(unsigned(date.month())),
                            int(unsigned(date.day())),
                            0.0,
                            &tai_minus_utc_s);
  if (status < 0) throw std::logic_error("leap second table: status " + std::to_string(status));
  return tai_minus_utc_s;
}

}  // namespace

double TaiMinusUtcS(std::chrono::sys_days day) {
  // ERFA sets up its table on the first call, without a lock.
  static const double first_entry_s = TableEntryS(kFirstLeapSecondDay);
  return day <= kFirstLeapSecondDay ? first_entry_s : TableEntryS(day);
}

bool LeapSecondEndsBefore(std::chrono::sys_days day) {
  return TaiMinusUtcS(day) - TaiMinusUtcS(day - std::chrono::days{1}) == 1.0;
}

}  // namespace pleinair
